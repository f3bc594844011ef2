// The server's threads on the bus.
#include "sim_server/bus_links.h"

#include <gtest/gtest.h>

#include "sim_server/messages_from_state.h"
#include "tests/support/bus.h"

namespace palp::test {
namespace {

using namespace std::chrono_literals;

ProxySample sample(double sim_time, std::uint32_t flags) {
  ProxySample s;
  s.flags = flags;
  s.sim_time = sim_time;
  return s;
}

// A slow server's answer comes again and again, a few times; that of one that is paused or coupled to nobody does not.
TEST(HapticLink, SendsAnAnswerAgainUntilThereIsANewerOne) {
  Scene scene;
  scene.proxies.resize(1);
  const auto out = open_bus(options_for(Vendor::cyclone)), in = open_bus(options_for(Vendor::cyclone));
  const auto reader = in->reader<ProxySample>();
  HapticLink link(*out, scene);
  std::vector<Received<ProxySample>> all;
  const auto comes = [&](std::uint64_t sequence) {
    reader->take_all(all);
    return !all.empty() && all.back().message.header.sequence >= sequence;
  };
  ASSERT_TRUE(eventually([&] {  // until both have found each other
    link.put(0, sample(0.25, kHealthy | kPaused));
    link.flush();
    return reader->wait(50ms) && comes(1);
  }));
  while (reader->wait(100ms)) comes(1);
  for (const std::uint32_t flags : {kHealthy | kEngaged, kHealthy | kPaused}) {
    const std::uint64_t first = all.back().message.header.sequence + 1,
                        last = first + ((flags & kEngaged) ? kMostRepeats : 0);
    all.clear();
    link.put(0, sample(0.5, flags));
    link.flush();
    ASSERT_TRUE(eventually([&] { return comes(last); }));
    while (reader->wait(100ms)) comes(last);
    for (const Received<ProxySample>& r : all) {  // a busy reader may have missed some
      EXPECT_EQ(r.message.sim_time, 0.5);
      EXPECT_EQ(r.message.flags, r.message.header.sequence == first ? flags : flags | kRepeated);
    }
    EXPECT_EQ(all.back().message.header.sequence, last);
  }
}

}  // namespace
}  // namespace palp::test
