// The last minute of the loop, tick by tick, in a ring of fixed size; written out as CSV when the bridge ends.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "haptic_bridge/loop.h"

namespace palp {

class FlightLog {
 public:
  // Allocates and touches room for so many ticks (at least 1).
  explicit FlightLog(std::size_t ticks);

  // No allocation, no lock, no throw, no system call.
  void add(const TickRecord& record) noexcept {
    ring_[count_ % ring_.size()] = record;
    ++count_;
  }
  std::size_t size() const { return count_ < ring_.size() ? count_ : ring_.size(); }
  std::size_t capacity() const { return ring_.size(); }
  // The i-th oldest record still held.
  const TickRecord& at(std::size_t i) const { return ring_[(count_ - size() + i) % ring_.size()]; }

  // Writes what is held, oldest first, to PATH.part and renames that: the path holds either the whole log or what was
  // there before. Missing directories are made. First line: column names with units (flight_log_columns() explains
  // them). Throws std::runtime_error with one sentence (disk full, no permission); what could be written stays in
  // PATH.part. Not while add() may be called.
  void write_csv(const std::string& path) const;

 private:
  std::vector<TickRecord> ring_;
  std::size_t count_ = 0;
};

// Room on the disk for a log of so many ticks, taken before a run: it does not find out at its end that it cannot write
// there, and a disk that fills meanwhile costs nothing. Where the file system cannot reserve, only the path is tried.
class LogRoom {
 public:
  // Makes the directories of the path and, empty but with its room, PATH.part, which write_csv uses. Throws as that.
  LogRoom(const std::string& path, std::size_t ticks);
  ~LogRoom();  // gives back what was not used
  LogRoom(const LogRoom&) = delete;
  LogRoom& operator=(const LogRoom&) = delete;

 private:
  std::string part_;
};

// One line per column of the CSV: "name: meaning".
std::string flight_log_columns();

}  // namespace palp
