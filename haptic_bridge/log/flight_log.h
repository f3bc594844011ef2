// The last minute of the loop, tick by tick, in a ring of fixed size; written out when the bridge ends, as CSV for
// people, and with all that the loop took in to be run again (rerun.h). The ring lies in shared memory: a process
// forked after it was made can write it when this one has been killed.
#pragma once

#include <atomic>
#include <cstddef>
#include <string>

#include "haptic_bridge/guard/shared_memory.h"
#include "haptic_bridge/loop/loop.h"

namespace palp {

class FlightLog {
 public:
  // Allocates and touches room for so many ticks (at least 1).
  explicit FlightLog(std::size_t ticks);

  // No allocation, no lock, no throw, no system call.
  void add(const TickRecord& record, const TickInput& input) noexcept {
    const std::size_t count = ticks();
    ring_[count % ring_.size()] = record;
    inputs_[count % ring_.size()] = input;
    state_[0].ticks.store(count + 1, std::memory_order_release);
  }
  std::size_t size() const { return ticks() < capacity() ? ticks() : capacity(); }
  // One place is never read: whoever is killed may have been writing there.
  std::size_t capacity() const { return ring_.size() - 1; }
  // The i-th oldest record still held.
  const TickRecord& at(std::size_t i) const { return ring_[place(i)]; }
  // Returns what the tick of the i-th oldest record took in.
  const TickInput& input_at(std::size_t i) const { return inputs_[place(i)]; }

  // Writes what is held, oldest first, to PATH.part and renames that: the path holds either the whole log or what was
  // there before. Missing directories are made. First line: column names with units (flight_log_columns() explains
  // them). Throws std::runtime_error with one sentence (disk full, no permission); what could be written stays in
  // PATH.part. Not while add() may be called.
  void write_csv(const std::string& path) const;

  // Returns whether the log has been written out, so that nobody else writes it; all processes that share the log see
  // it.
  bool is_written() const { return state_[0].written.load(std::memory_order_acquire); }
  void set_written() const { state_[0].written.store(true, std::memory_order_release); }

 private:
  struct State {
    std::atomic<std::size_t> ticks{0};
    mutable std::atomic<bool> written{false};
  };
  std::size_t ticks() const { return state_[0].ticks.load(std::memory_order_acquire); }
  std::size_t place(std::size_t i) const { return (ticks() - size() + i) % ring_.size(); }

  SharedArray<TickRecord> ring_;
  SharedArray<TickInput> inputs_;
  SharedArray<State> state_{1};
};

// A log of so many ticks is no longer than this.
std::size_t most_csv_bytes(std::size_t ticks);

// One line per column of the CSV: "name: meaning".
std::string flight_log_columns();

}  // namespace palp
