// Who is held of several senders of the same thing, and when another one takes its place.
#include "idl/session_hold.h"

#include <gtest/gtest.h>

#include "haptic_bridge/number_watch.h"
#include "idl/roster.h"

namespace palp::test::session_hold_test {
namespace {

constexpr std::int64_t kMs = 1'000'000;
using Heard = std::vector<std::uint64_t>;

// A receiver that looks every millisecond; senders are heard in each look.
struct Receiver {
  SessionHold hold{kDeviceHold};
  std::int64_t t_ns = 0;
  std::uint64_t listen(const Heard& heard, std::int64_t ms) {
    std::uint64_t held = hold.held();
    for (std::int64_t i = 0; i < ms; ++i) held = hold.look(heard, t_ns += kMs);
    return held;
  }
};

TEST(SessionHold, HoldsTheFirstWhateverOthersSend) {
  Receiver receiver;
  EXPECT_EQ(receiver.listen({}, 10), 0u);
  EXPECT_EQ(receiver.listen({1}, 50), 1u);
  EXPECT_EQ(receiver.hold.rival(0), 0u);
  for (int i = 0; i < 500; ++i) {
    ASSERT_EQ(receiver.listen({2, 1}, 1), 1u);
    ASSERT_EQ(receiver.listen({2}, 150), 1u) << "a link that loses some is not a bridge that has ended";
  }
  EXPECT_EQ(receiver.hold.rival(1000 * kMs), 2u);
  EXPECT_EQ(receiver.listen({1}, 250), 1u);
  EXPECT_EQ(receiver.hold.rival(0), 0u) << "it has gone";
}

TEST(SessionHold, OneThatWasKilledIsReplacedWithinATenthOfASecondOrTwo) {
  Receiver receiver;
  receiver.listen({1}, 50);
  receiver.listen({}, 50);
  EXPECT_EQ(receiver.listen({2}, 100), 1u) << "nobody knows yet that it was killed";
  EXPECT_EQ(receiver.listen({2}, 60), 2u);
}

// Hung for ten seconds while another one took the number; then it wakes.
TEST(SessionHold, OneThatHungAndWakesDoesNotGetItsPlaceBack) {
  Receiver receiver;
  receiver.listen({1}, 50);
  EXPECT_EQ(receiver.listen({}, 100), 1u);
  EXPECT_EQ(receiver.listen({2}, 10'000), 2u);
  EXPECT_EQ(receiver.listen({1, 2}, 100), 2u);
  EXPECT_EQ(receiver.listen({1}, 5'000), 2u) << "the one that holds it has a hiccup, or has ended";
  EXPECT_EQ(receiver.listen({3, 1}, 2), 3u);
  // after long silence it is one as any other
  receiver.listen({}, 21'000);
  EXPECT_EQ(receiver.listen({1}, 2), 1u);
}

TEST(SessionHold, OneThatHungWhileNobodyCameGoesOn) {
  Receiver receiver;
  receiver.listen({1}, 50);
  receiver.listen({}, 10'000);
  EXPECT_EQ(receiver.listen({1}, 1), 1u);
}

TEST(SessionHold, AServerThatIsHeardAgainIsAsGoodAsAnyOther) {
  SessionHold hold(kServerHold);
  hold.look(Heard{1}, kMs);
  for (int i = 0; i < 20; ++i) hold.look(Heard{2}, (2 + 10 * i) * kMs);
  EXPECT_EQ(hold.held(), 2u);
  for (int i = 20; i < 40; ++i) hold.look(Heard{1}, (2 + 10 * i) * kMs);
  EXPECT_EQ(hold.held(), 1u);
}

// The receiver was stopped for a second: whoever it finds first in its queue is not the only one that lives.
TEST(SessionHold, AReceiverThatStoodStillTakesNobodyForDead) {
  Receiver receiver;
  receiver.listen({1, 2}, 50);
  receiver.t_ns += 1000 * kMs;
  EXPECT_EQ(receiver.listen({2}, 1), 1u);
  EXPECT_EQ(receiver.listen({2, 1}, 1), 1u);
}

TEST(SessionHold, LetsGoOfOneThatSaysThatItEnds) {
  Receiver receiver;
  receiver.listen({1, 2}, 50);
  receiver.hold.let_go(2);
  EXPECT_EQ(receiver.hold.held(), 1u);
  receiver.hold.let_go(1);
  EXPECT_EQ(receiver.listen({2}, 1), 2u);
}

TEST(SessionHold, AThousandSendersDoNotPushOutTheOneThatIsHeld) {
  Receiver receiver;
  receiver.listen({1}, 50);
  for (std::uint64_t other = 2; other < 1000; ++other) ASSERT_EQ(receiver.listen({other, 1}, 1), 1u);
}

ProxySample answer_to(std::uint64_t session, std::uint64_t sequence) {
  ProxySample s;
  s.device_session = session;
  s.device_sequence = sequence;
  return s;
}

TEST(NumberWatch, FindsALiveBridgeThatIsAnsweredInstead) {
  NumberWatch watch(1);
  for (int i = 0; i < 2000; ++i) {
    watch.see(answer_to(2, 10 + static_cast<std::uint64_t>(i)), i * kMs);
    ASSERT_EQ(watch.holder(), i < 1000 ? 0u : 2u) << i;
  }
  watch.see(answer_to(1, 1), 2001 * kMs);
  EXPECT_EQ(watch.holder(), 0u);
}

TEST(NumberWatch, TakesNoAnswerToADeadBridgeForALiveOne) {
  NumberWatch watch(1);
  for (int i = 0; i < 200; ++i) watch.see(answer_to(2, 10 + static_cast<std::uint64_t>(i)), i * kMs);
  for (int i = 200; i < 60'000; ++i) watch.see(answer_to(2, 209), i * kMs);
  for (int i = 0; i < 2000; ++i) watch.see(answer_to(0, 0), (60'000 + i) * kMs);
  EXPECT_EQ(watch.holder(), 0u);
}

Received<Status> status_of(const std::string& process, std::uint64_t session, std::int64_t t_ns) {
  Received<Status> r;
  r.message.process = process;
  r.message.header.session = session;
  r.message.metrics = {{"rate_hz", 1000}, {"pid_on_lab3", 4711}};
  r.t_receive_ns = t_ns;
  return r;
}

TEST(Roster, TellsProcessesOfOneNameApartAndForgetsThoseThatAreSilent) {
  Roster roster;
  roster.add(status_of("haptic_bridge 0", 1, 0));
  roster.add(status_of("haptic_bridge 0", 2, 0));
  roster.add(status_of("haptic_bridge 0", 2, 5));
  EXPECT_EQ(roster.peers().size(), 2u);
  EXPECT_EQ(roster.name_of_session(1), "haptic_bridge 0 (process 4711 on lab3)");
  EXPECT_NE(roster.name_of_session(3).find("session 3"), std::string::npos);
  EXPECT_EQ(roster.server_beside(9), nullptr);
  roster.add(status_of("sim_server", 7, 5));
  ASSERT_NE(roster.server_beside(9), nullptr);
  EXPECT_EQ(roster.server_beside(9)->session(), 7u);
  EXPECT_EQ(roster.server_beside(7), nullptr);
  Received<Status> last = status_of("sim_server", 7, 6);
  last.message.state = "ended";
  roster.add(last);
  EXPECT_EQ(roster.server_beside(9), nullptr);
  roster.forget(kGoneAfterNs + 1);
  EXPECT_EQ(roster.find(1), nullptr);
  EXPECT_NE(roster.find(2), nullptr);
}

TEST(Roster, EveryStatusNamesItsProcessOnce) {
  const Metric metric = process_metric();
  Status status;
  status.process = "viewer";
  EXPECT_EQ(name_of(status), "viewer");
  status.metrics = {metric};
  EXPECT_NE(name_of(status).find("(process " + std::to_string(static_cast<long>(metric.value)) + " on "),
            std::string::npos);
}

}  // namespace
}  // namespace palp::test::session_hold_test
