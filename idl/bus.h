// The bus: five verbs over plain structs (messages.h), with a Cyclone DDS and a Fast DDS implementation behind them.
// No vendor header is seen here. Topic names and quality of service stand in topics.h.
//
// Threads: a Bus may be used from any thread. A Writer or Reader belongs to one thread at a time. None of this belongs
// on the 1 kHz path: the bridge's loop meets the bus's thread in a mailbox (latest.h).
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "idl/messages.h"

namespace palp {

enum class Vendor { cyclone, fastdds };

inline constexpr int kMaxDomain = 232;

struct BusOptions {
  Vendor vendor = Vendor::cyclone;
  int domain = 0;         // DDS domain, 0..232
  bool network = false;   // false: loopback interface only; the same for all who shall meet
  std::string interface;  // address or name of the network interface; empty: the vendor's choice (with network)
  std::vector<std::string> peers;  // addresses of other hosts; not empty implies network
  int socket_buffer_bytes = 0;     // receive buffer to ask the system for; 0: 64 MB, of which it gives what it allows
};

// A sample as a reader hands it on: its content, and when it came.
template <class T>
struct Received {
  T message;
  std::int64_t t_receive_ns = 0;  // CLOCK_MONOTONIC of this host, when it was taken from the vendor
};

// Counts what a reader refused. A refused sample is counted and dropped, never handed on.
struct DropCounts {
  std::uint64_t wrong_version = 0;
  std::uint64_t not_finite = 0;     // NaN or infinity anywhere
  std::uint64_t malformed = 0;      // lengths, indices, enumerators, quaternions out of range, undecodable bytes
  std::uint64_t lost = 0;           // gaps in the sequence: not delivered, or overwritten by a newer one before taken
  std::uint32_t other_version = 0;  // the last wrong version seen (validate.h makes a sentence of it)
};

template <class T>
class Writer {
 public:
  virtual ~Writer() = default;
  // Fills header.version, session, sequence and t_send_ns and sends. False if the vendor refused (counted, not thrown).
  virtual bool publish(T& message) = 0;
  virtual int matched_readers() const = 0;
};

template <class T>
class Reader {
 public:
  virtual ~Reader() = default;
  // Takes the newest sample that has arrived since the last call, whatever its key; older ones are passed over, also
  // those of other keys: with several devices or processes use take_all. Newest is by the senders' clocks across keys.
  // False if none.
  virtual bool take_latest(Received<T>& out) = 0;
  // Takes everything that has arrived, oldest first, and appends it to out. Returns how many. How much is kept until
  // taken is the reader depth of topics.h, for each key.
  virtual std::size_t take_all(std::vector<Received<T>>& out) = 0;
  // Waits until a sample may be there or the time is up. True if one may be there.
  virtual bool wait(std::chrono::nanoseconds timeout) = 0;
  virtual DropCounts drops() const = 0;
  virtual int matched_writers() const = 0;
};

class Bus {
 public:
  virtual ~Bus() = default;
  std::uint64_t session() const { return session_; }
  Vendor vendor() const { return vendor_; }
  int domain() const { return domain_; }

  // T: a message that has a topic (topics.h).
  template <class T>
  std::unique_ptr<Writer<T>> writer();
  template <class T>
  std::unique_ptr<Reader<T>> reader();

 protected:
  std::uint64_t session_ = 0;
  Vendor vendor_ = Vendor::cyclone;
  int domain_ = 0;
};

// Throws std::runtime_error with one sentence when the participant cannot be created or the vendor's configuration
// (CYCLONEDDS_URI, FASTRTPS_DEFAULT_PROFILES_FILE) is missing or malformed.
std::unique_ptr<Bus> open_bus(const BusOptions& options);

const char* to_string(Vendor vendor);
// Throws std::invalid_argument naming what is accepted.
Vendor vendor_from(const std::string& text);

}  // namespace palp
