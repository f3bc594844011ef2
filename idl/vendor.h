// The functions that a DDS vendor must offer to the bus. bus.cpp puts validation, stamping and counting on top; nothing
// else includes this header.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "idl/bus.h"
#include "idl/topics.h"

namespace palp {

// A participant, open as long as anyone holds it; its end points hold it too.
class Participant {
 public:
  virtual ~Participant() = default;
};

// One sample as the vendor delivered it: decoded, not checked.
template <class T>
struct Taken {
  T message;
  std::int64_t source_time_ns = 0;  // the sender's wall clock: only to order samples of different keys
};

template <class T>
class Sink {
 public:
  virtual ~Sink() = default;
  virtual bool write(const T& message) = 0;
  virtual int matched() const = 0;
};

template <class T>
class Source {
 public:
  virtual ~Source() = default;
  // Appends what has arrived to out, reusing out[count...] where there are elements. Returns the new count.
  virtual std::size_t take(std::vector<Taken<T>>& out, std::size_t count) = 0;
  virtual bool wait(std::chrono::nanoseconds timeout) = 0;
  virtual int matched() const = 0;
  // Samples whose bytes the vendor's decoder refused, as far as the vendor tells.
  virtual std::uint64_t undecodable() const = 0;
};

std::shared_ptr<Participant> open_cyclone(const BusOptions& options);
std::shared_ptr<Participant> open_fastdds(const BusOptions& options);

// Throw std::runtime_error with one sentence if the vendor refuses. Instantiated for every message.
template <class T>
std::unique_ptr<Sink<T>> cyclone_sink(std::shared_ptr<Participant> participant);
template <class T>
std::unique_ptr<Source<T>> cyclone_source(std::shared_ptr<Participant> participant);
template <class T>
std::unique_ptr<Sink<T>> fastdds_sink(std::shared_ptr<Participant> participant);
template <class T>
std::unique_ptr<Source<T>> fastdds_source(std::shared_ptr<Participant> participant);

}  // namespace palp
