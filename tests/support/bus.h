// Helpers that the tests of the bus share.
#pragma once

#include <unistd.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <tuple>
#include <utility>

#include "idl/bus.h"
#include "idl/vendor.h"
#include "tests/support/eventually.h"

namespace palp::test {

using namespace std::chrono_literals;

// Returns a domain that no other test running at the same time is likely to use.
inline int test_domain() { return 100 + static_cast<int>(getpid() % 101); }

inline BusOptions options_for(Vendor vendor) {
  BusOptions options;
  options.vendor = vendor;
  options.domain = test_domain();
  return options;
}

// Which vendor writes and which reads.
using Pairing = std::tuple<Vendor, Vendor>;

template <class Info>
std::string pairing_name(const Info& info) {
  return std::string(to_string(std::get<0>(info.param))) + "_to_" + to_string(std::get<1>(info.param));
}

// End points below the checks of the bus, to send what the bus never would.
inline std::shared_ptr<Participant> open_raw(Vendor vendor) {
  return vendor == Vendor::cyclone ? open_cyclone(options_for(vendor)) : open_fastdds(options_for(vendor));
}
template <class T>
std::unique_ptr<Sink<T>> raw_sink(Vendor vendor, std::shared_ptr<Participant> participant) {
  return vendor == Vendor::cyclone ? cyclone_sink<T>(std::move(participant)) : fastdds_sink<T>(std::move(participant));
}
template <class T>
std::unique_ptr<Source<T>> raw_source(Vendor vendor, std::shared_ptr<Participant> participant) {
  return vendor == Vendor::cyclone ? cyclone_source<T>(std::move(participant))
                                   : fastdds_source<T>(std::move(participant));
}

}  // namespace palp::test
