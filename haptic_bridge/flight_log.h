// The last minute of the loop, tick by tick, in a ring of fixed size; written out when the bridge ends, as CSV for
// people, and with all that the loop took in to be run again (rerun.h).
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
  void add(const TickRecord& record, const TickInput& input) noexcept {
    ring_[count_ % ring_.size()] = record;
    inputs_[count_ % ring_.size()] = input;
    ++count_;
  }
  std::size_t size() const { return count_ < ring_.size() ? count_ : ring_.size(); }
  std::size_t capacity() const { return ring_.size(); }
  // The i-th oldest record still held.
  const TickRecord& at(std::size_t i) const { return ring_[place(i)]; }
  // What that tick took in.
  const TickInput& input_at(std::size_t i) const { return inputs_[place(i)]; }

  // Writes what is held, oldest first, to PATH.part and renames that: the path holds either the whole log or what was
  // there before. Missing directories are made. First line: column names with units (flight_log_columns() explains
  // them). Throws std::runtime_error with one sentence (disk full, no permission); what could be written stays in
  // PATH.part. Not while add() may be called.
  void write_csv(const std::string& path) const;

 private:
  std::size_t place(std::size_t i) const { return (count_ - size() + i) % ring_.size(); }

  std::vector<TickRecord> ring_;
  std::vector<TickInput> inputs_;
  std::size_t count_ = 0;
};

// A log of so many ticks is no longer than this.
std::size_t most_csv_bytes(std::size_t ticks);

// One line per column of the CSV: "name: meaning".
std::string flight_log_columns();

}  // namespace palp
