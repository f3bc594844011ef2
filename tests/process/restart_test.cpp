// A process is killed, as by kill -9, while the others run, and started again.
#include <cmath>

#include "idl/clock.h"
#include "tests/process/running_system.h"
#include "tests/support/flight_table.h"

namespace palp::test::restart_test {
namespace {

class Restart : public RunningSystem {};

TEST_F(Restart, ForceEndsWithin100MsOfTheServersDeathAndComesBackWithTheNextOne) {
  Watcher& watcher = watch();
  start_server();
  start_bridge();
  ASSERT_TRUE(force_is_felt(watcher)) << said();

  const std::int64_t t_dead_ns = now_ns();
  server_->stop(SIGKILL);
  ASSERT_TRUE(watcher.sees([&] { return watcher.says("haptic_bridge 0", "stale"); })) << said();
  ASSERT_TRUE(watcher.sees([&] { return now_ns() > t_dead_ns + 500'000'000; }));
  EXPECT_TRUE(watcher.has_event("the server has fallen silent"));

  const std::int64_t t_again_ns = now_ns();
  watcher.status.clear();
  start_server();
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  stop_bridge();
  stop_server();

  const FlightTable log(folder_ / "flight.csv");
  ASSERT_GT(log.ticks(), 500u);
  // what was under way when the server died may still come in; from then on the clock runs
  std::int64_t t_lost_ns = t_dead_ns;
  double before = 0, dead = 0, after = 0;
  for (std::size_t i = 1; i < log.ticks(); ++i) {
    const std::int64_t t = log.t_ns(i);
    const double force = log.felt(i);
    ASSERT_TRUE(std::isfinite(force)) << "tick " << log.text("tick", i);
    if (t > t_dead_ns && t < t_again_ns && log.text("sequence", i) != log.text("sequence", i - 1)) t_lost_ns = t;
    if (t <= t_dead_ns) before = std::max(before, force);
    if (t > t_lost_ns + 100'000'000 && t < t_again_ns) dead = std::max(dead, force);
    if (t >= t_again_ns) after = std::max(after, force);
  }
  EXPECT_LT(t_lost_ns - t_dead_ns, 50'000'000) << "samples came from a dead server";
  EXPECT_GT(before, 0.5);
  EXPECT_EQ(dead, 0);
  EXPECT_GT(after, 0.5);
}

TEST_F(Restart, TheServerHoldsTheProxyOfADeadBridgeAndTheNextOneTakesIt) {
  Watcher& watcher = watch();
  start_server();
  start_bridge();
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  const std::uint64_t first_bridge = watcher.proxy.device_session;

  bridge_->stop(SIGKILL);
  ASSERT_TRUE(watcher.sees([&] { return (watcher.proxy.flags & kEngaged) == 0; })) << said();
  const ProxySample let_go = watcher.proxy;
  ASSERT_TRUE(watcher.sees([&] { return watcher.proxy.sim_time > let_go.sim_time + 0.3; })) << said();
  EXPECT_EQ(watcher.proxy.flags & (kEngaged | kHealthy), kHealthy);
  EXPECT_EQ(watcher.proxy.proxy_pose, let_go.proxy_pose) << "the tool moved although nobody held it";
  EXPECT_EQ(watcher.proxy.wrench, WrenchD{});
  // what it had logged is not lost with it
  EXPECT_TRUE(watcher.sees([&] { return said().find("the flight log was written to") != std::string::npos; }))
      << said();
  const FlightTable log(folder_ / "flight.csv");
  ASSERT_GT(log.ticks(), 100u);
  EXPECT_GT(std::abs(log.number("force_z", log.ticks() - 1)), 0.1) << "the last tick is that of a bridge at work";
  ChildProcess again({PALP_BIN_DIR "/palp-haptic-bridge", "--rerun", folder_ / "flight.ticks"}, folder_ / "again.txt");
  EXPECT_EQ(again.wait(), 0) << again.output();

  watcher.status.clear();
  start_bridge();
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  EXPECT_NE(watcher.proxy.device_session, first_bridge);
  stop_bridge();
  stop_server();
}

TEST_F(Restart, NobodyMissesADeadViewerAndTheNextOneSeesEverything) {
  Watcher& watcher = watch();
  start_server();
  start_viewer();
  ASSERT_TRUE(viewer_draws(watcher)) << said();
  start_bridge();
  ASSERT_TRUE(force_is_felt(watcher)) << said();

  const double stale = watcher.metric("haptic_bridge 0", "stale_events");
  viewer_->stop(SIGKILL);
  const double steps = watcher.metric("sim_server", "steps");
  EXPECT_TRUE(watcher.sees([&] { return watcher.metric("sim_server", "steps") > steps + 800; })) << said();
  EXPECT_EQ(watcher.metric("haptic_bridge 0", "stale_events"), stale);
  EXPECT_TRUE(watcher.says("haptic_bridge 0", "engaged"));

  watcher.status.erase("viewer");
  start_viewer(Vendor::fastdds);
  EXPECT_TRUE(viewer_draws(watcher)) << said();
  EXPECT_NE(viewer_->output().find("scene 'small_tray'"), std::string::npos) << said();
  EXPECT_TRUE(force_is_felt(watcher)) << said();
  stop_viewer();
  stop_bridge();
  stop_server();
}

}  // namespace
}  // namespace palp::test::restart_test
