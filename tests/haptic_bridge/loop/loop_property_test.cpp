// Randomised schedules: whatever the server, the bus, the device and the scheduler do, the wrench stays within its
// limits in every tick, and the same schedule gives the same wrenches, bit for bit.
#include <bit>
#include <map>

#include <gtest/gtest.h>

#include "haptic_bridge/loop/loop.h"
#include "tests/haptic_bridge/loop/fault_injector.h"
#include "tests/haptic_bridge/loop/invariants.h"
#include "tests/support/seed.h"

namespace palp::test::loop_property_test {
namespace {

#ifdef __SANITIZE_ADDRESS__
constexpr int kSchedules = 3000;  // the sanitizer makes them forty times slower; fewer may miss what is rare
#else
constexpr int kSchedules = 10000;
#endif
constexpr int kTicks = 60;          // per short schedule
constexpr int kLongSchedules = 30;  // long enough to engage, go stale and come back
constexpr int kLongTicks = 3000;

struct Outcome {
  std::uint64_t hash = 1469598103934665603u;  // of every wrench sent
  std::map<std::string, int> ticks;           // that were of some kind
  bool had_force = false;                     // in the last one
  void add(double x) { hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 1099511628211u; }
  void note(const HapticLoop& loop) {
    const TickRecord& r = loop.record();
    const TickInput& in = loop.input();
    const double v = r.device.linear.norm(), force = r.sent.force.norm();
    ++ticks[to_string(r.state)];
    if (in.came) ++ticks[to_string(static_cast<Verdict>(r.verdict))];
    ticks["force"] += force > 0;
    ticks["damped"] += r.damping_linear > 0 && force > 0;
    ticks["power limit"] += r.reduced && force > 0;
    ticks["too fast"] += v > loop.config().safety.tool_speed && force > 0;
    ticks["gains lowered"] += r.gains_share < 1;
    ticks["shifted"] += in.reading.shifted && r.good_reading;
    ticks["strained"] += in.reading.strained && force > 0;
    ticks["read failed"] += !in.was_read;
    ticks["write failed"] += !in.was_written;
    ticks["overrun"] += in.lateness_ns > 5'000'000;
    ticks["cut"] += r.cut && had_force;
    had_force = force > 0;
  }
};

Outcome run_schedule(std::uint64_t seed, int ticks) {
  FaultInjector injector(seed);
  const LoopConfig config = injector.config();
  FaultyArm arm(injector);
  HapticLoop loop(config, arm);
  Invariants invariants(loop.config());
  Outcome outcome;
  std::int64_t now = 1'000'000'000;
  for (int i = 0; i < ticks; ++i) {
    const std::int64_t wait = injector.wait_ns();
    now += wait;
    IncomingProxy in;
    const bool came = injector.next(loop.sample(), now, in);
    loop.tick(now, wait - kMillisecond, static_cast<std::uint32_t>(wait / kMillisecond - 1), came ? &in : nullptr);
    if (const char* wrong = invariants.judge(loop, arm.written)) {
      ADD_FAILURE() << wrong << ": schedule " << seed << ", tick " << i;
      return outcome;
    }
    outcome.note(loop);
    for (int k = 0; k < 3; ++k) outcome.add(arm.written.force[k]), outcome.add(arm.written.torque[k]);
  }
  return outcome;
}

// Expects that the schedules have reached all that they are to test, or they prove nothing.
void expect_all_reached(const std::map<std::string, int>& reached, const std::vector<std::string>& rare = {}) {
  for (const char* what :
       {"waiting",   "ready",        "engaged",     "idle",         "degraded",    "stale",        "locked",
        "accepted",  "restarted",    "force",       "damped",       "power limit", "too fast",     "gains lowered",
        "shifted",   "strained",     "read failed", "write failed", "overrun",     "out_of_order", "not_finite",
        "bad_range", "other_bridge", "bad_gains",   "cut"})
    EXPECT_GT(reached.contains(what) ? reached.at(what) : 0, 20) << what;
  for (const std::string& what : rare) EXPECT_GT(reached.contains(what) ? reached.at(what) : 0, 0) << what;
}

std::map<std::string, int> run_schedules(unsigned seed, int schedules, int ticks) {
  std::map<std::string, int> reached;
  for (int i = 0; i < schedules && !::testing::Test::HasFailure(); ++i)
    for (const auto& [what, n] : run_schedule(seed + static_cast<unsigned>(i), ticks).ticks) reached[what] += n;
  return reached;
}

TEST(LoopProperty, LimitsHoldInEveryTickOfEverySchedule) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("base seed " + std::to_string(seed));
  const std::map<std::string, int> reached = run_schedules(seed, kSchedules, kTicks);
  expect_all_reached(reached, {"fault"});
  EXPECT_GT(reached.at("force"), kSchedules * kTicks / 20);  // the schedules do reach force
  if (HasFailure() || std::getenv("PALP_SEED") != nullptr)
    for (const auto& [what, n] : reached) std::cout << what << ": " << n << " ticks\n";
}

TEST(LoopProperty, LimitsHoldInLongSchedules) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("base seed " + std::to_string(seed));
  const std::map<std::string, int> reached = run_schedules(seed, kLongSchedules, kLongTicks);
  EXPECT_GT(reached.at("force"), kLongSchedules * kLongTicks / 40);
}

TEST(LoopProperty, TheSameInputsGiveTheSameWrenchesBitForBit) {
  int felt = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Outcome one = run_schedule(seed, 1000), two = run_schedule(seed, 1000);
    EXPECT_EQ(one.hash, two.hash) << "seed " << seed;
    if (one.ticks.at("force") == 0) continue;
    ++felt;
    EXPECT_NE(one.hash, run_schedule(seed + 1000, 1000).hash);
  }
  EXPECT_GE(felt, 5);
}

}  // namespace
}  // namespace palp::test::loop_property_test
