// Reads and writes the serialised samples of palp's topics as they stand on the wire, without knowing their types, so
// that a recording holds the very bytes that were sent. The same topics and quality of service as the bus (topics.h),
// with either vendor. A payload is an RTPS SerializedPayload: 4 bytes of encapsulation header, then CDR.
//
// Threads: one thread for all readers of a RawBus and its wait(); a writer belongs to one thread at a time.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "idl/bus.h"
#include "idl/topics.h"

namespace palp {

using Payload = std::span<const std::uint8_t>;

class RawReader {
 public:
  virtual ~RawReader() = default;
  // Hands over what has arrived, oldest first: the payload, valid during the call, and the sender's time stamp
  // [ns since 1970]. Returns how many.
  virtual std::size_t take(const std::function<void(Payload, std::int64_t source_time_ns)>& on_sample) = 0;
  virtual std::uint64_t lost() const = 0;  // as far as the vendor knows
  virtual int matched_writers() const = 0;
};

class RawWriter {
 public:
  virtual ~RawWriter() = default;
  // The source time stamp is that of the call. False if the vendor refused or the payload is no CDR of this topic's
  // key.
  virtual bool write(Payload payload) = 0;
  virtual int matched_readers() const = 0;
  // Reliable topics: true once all matched readers have what was written.
  virtual bool wait_acknowledged(std::chrono::milliseconds timeout) = 0;
};

class RawBus {
 public:
  virtual ~RawBus() = default;
  // Keeps up to `depth` samples (per key) between two calls of take(). Throw std::runtime_error if the vendor refuses.
  virtual std::unique_ptr<RawReader> reader(const TopicRow& topic, int depth) = 0;
  virtual std::unique_ptr<RawWriter> writer(const TopicRow& topic) = 0;
  // Waits until a reader may have something or the time is up. True if one may.
  virtual bool wait(std::chrono::milliseconds timeout) = 0;
};

// Opens the bus as open_bus() does, for samples as bytes.
std::unique_ptr<RawBus> open_raw_bus(const BusOptions& options);
std::unique_ptr<RawBus> open_raw_cyclone(const BusOptions& options);
std::unique_ptr<RawBus> open_raw_fastdds(const BusOptions& options);

// Gives the key, which is the first member of the type and has so many bytes (TopicRow), as DDS hashes it: big-endian,
// the rest zero. Returns false when the payload is too short or no plain
// CDR.
bool raw_key(Payload payload, std::size_t bytes, std::array<std::uint8_t, 16>& key);

}  // namespace palp
