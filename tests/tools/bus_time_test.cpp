// The bench's measurement of the bus: most of what was sent in real time arrives, and the times are in order.
#include "tools/haptic_bench/bus_time.h"

#include <gtest/gtest.h>
#include <unistd.h>

namespace palp::test {
namespace {

using namespace bench;

TEST(BusTimes, AreThoseOfMostSamplesForBothVendors) {
  const int domain = 101 + getpid() % 100;
  const std::vector<BusTime> times = bus_times(domain, 0.3);
  ASSERT_EQ(times.size(), 2u);
  for (const BusTime& t : times) {
    EXPECT_EQ(t.sent, 300u) << t.vendor;
    EXPECT_GT(t.received, 150u) << t.vendor;
    EXPECT_GT(t.median_us, 0) << t.vendor;
    EXPECT_LE(t.median_us, t.p99_us) << t.vendor;
    EXPECT_LE(t.p99_us, t.p999_us) << t.vendor;
    EXPECT_LE(t.p999_us, t.max_us) << t.vendor;
  }
}

}  // namespace
}  // namespace palp::test
