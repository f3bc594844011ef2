// Two bridges of one device number, two servers in one domain: one of them counts, the other is refused or passed over,
// everybody is told, and no hand feels both.
#include "idl/clock.h"
#include "tests/process/running_system.h"
#include "tests/support/flight_table.h"

namespace palp::test::two_of_a_kind_test {
namespace {

class TwoOfAKind : public RunningSystem, public testing::WithParamInterface<Vendor> {
 protected:
  std::unique_ptr<ChildProcess> another(const std::string& program, const std::string& name, Vendor vendor,
                                        const std::vector<std::string>& arguments) {
    std::vector<std::string> command{kBin + program,          "--dds",     to_string(vendor),         "--domain",
                                     std::to_string(domain_), "--summary", folder_ / (name + ".json")};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return std::make_unique<ChildProcess>(command, folder_ / (name + ".txt"));
  }
  // Another bridge, far away from the tool and holding on to it.
  std::unique_ptr<ChildProcess> bridge_far_away(const std::string& name, Vendor vendor) {
    return another("palp-haptic-bridge", name, vendor,
                   {"--home", "0.2", "0.2", "0.5", "--log", folder_ / (name + ".csv"), "--self-test", "0"});
  }
  static std::string process_of(const ChildProcess& child) {
    return "(process " + std::to_string(child.pid()) + " on ";
  }
  // The first bridge alone has moved the tool, and its hand has felt only that.
  void expect_undisturbed(const std::string& flight, std::int64_t from_ns, std::int64_t to_ns) {
    const FlightTable log(folder_ / flight);
    std::size_t ticks = 0, engaged = 0;
    for (std::size_t i = 0; i < log.ticks(); ++i) {
      const std::int64_t t = log.t_ns(i);
      if (t < from_ns || t > to_ns) continue;
      ++ticks;
      if (log.text("state", i) == "engaged" || log.text("state", i) == "degraded") ++engaged;
      // its hand moves up and down alone, and the other one holds on far to the side
      const auto aside = [&](const char* column) { return std::abs(log.number(column, i)); };
      ASSERT_LT(std::max(aside("proxy_x"), aside("proxy_y")), 0.01) << "tick " << log.text("tick", i);
    }
    EXPECT_GT(ticks, 500u);
    EXPECT_GT(engaged, ticks / 2);
  }
};

TEST_P(TwoOfAKind, TheSecondBridgeOfADeviceNumberEndsAndTheFirstFeelsNothing) {
  Watcher& watcher = watch();
  start_server(GetParam());
  start_bridge();
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  const std::uint64_t first = watcher.proxy.device_session;

  const std::int64_t t_second_ns = now_ns();
  const auto second = bridge_far_away("second", GetParam());
  bool only_first = true;
  const auto refused = [&] {
    only_first = only_first && watcher.proxy.device_session == first;
    return text_of(folder_ / "second.json").find("trouble") != std::string::npos;
  };
  EXPECT_TRUE(watcher.sees(refused)) << second->output();
  EXPECT_EQ(second->wait(), 1) << second->output();
  EXPECT_NE(second->output().find("device number 0 is held by haptic_bridge 0 " + process_of(*bridge_)),
            std::string::npos)
      << second->output();
  EXPECT_EQ(number_in_json(text_of(folder_ / "second.json"), "peak_force_n"), 0) << "it felt what was the other's";
  EXPECT_TRUE(only_first) << "the server answered the second bridge";
  EXPECT_TRUE(watcher.sees([&] { return watcher.has_event("device number 0 is held by"); })) << said();
  const std::int64_t t_refused_ns = now_ns();
  ASSERT_TRUE(watcher.sees([&] { return now_ns() > t_refused_ns + 300'000'000; }));
  stop_bridge();
  expect_undisturbed("flight.csv", t_second_ns, t_refused_ns);
  stop_server();
}

TEST_P(TwoOfAKind, ABridgeThatWasKilledIsReplacedByTheNextOneAtOnce) {
  Watcher& watcher = watch();
  start_server(GetParam());
  start_bridge();
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  const std::uint64_t first = watcher.proxy.device_session;
  bridge_->send_signal(SIGKILL);  // and no time until the next one starts
  const auto dead = std::move(bridge_);
  watcher.status.clear();
  start_bridge();
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  EXPECT_NE(watcher.proxy.device_session, first);
  EXPECT_FALSE(watcher.has_event("is held by")) << "nobody was refused";
  stop_bridge();
  stop_server();
}

TEST_P(TwoOfAKind, ABridgeThatHungDoesNotTakeItsNumberBack) {
  Watcher& watcher = watch();
  start_server(GetParam());
  start_bridge();
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  const std::uint64_t first = watcher.proxy.device_session;
  bridge_->send_signal(SIGSTOP);
  const auto second = another("palp-haptic-bridge", "second", GetParam(),
                              {"--hand", kHere + "dip.toml", "--log", folder_ / "second.csv", "--self-test", "0"});
  ASSERT_TRUE(watcher.sees([&] { return watcher.proxy.device_session != first && watcher.proxy.device_session != 0; }));
  const std::uint64_t heir = watcher.proxy.device_session;
  ASSERT_TRUE(watcher.sees([&] { return (watcher.proxy.flags & kEngaged) != 0; })) << said();

  bridge_->send_signal(SIGCONT);
  bool only_heir = true;
  const std::int64_t t_awake_ns = now_ns();
  EXPECT_TRUE(watcher.sees([&] {
    only_heir = only_heir && watcher.proxy.device_session == heir;
    return now_ns() > t_awake_ns + 2'000'000'000;
  }));
  EXPECT_TRUE(only_heir) << "the one that woke was answered";
  EXPECT_EQ(bridge_->wait(), 1) << bridge_->output();
  EXPECT_NE(bridge_->output().find("is held by haptic_bridge 0 " + process_of(*second)), std::string::npos)
      << bridge_->output();
  EXPECT_EQ(second->stop(), 0) << second->output();
  stop_server();
}

TEST_P(TwoOfAKind, ASecondServerIsPassedOverUntilTheFirstDies) {
  Watcher& watcher = watch();
  start_server();
  start_bridge();
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  const std::string first_name = process_of(*server_);

  const auto recorder = start_tool("palp-record", GetParam(), {"--out", folder_ / "run.mcap"});
  const std::int64_t t_second_ns = now_ns();
  const auto second = another("palp-sim-server", "second", GetParam(), {kHere + "small_tray.toml", "--backend", "cpu"});
  EXPECT_TRUE(watcher.sees([&] { return watcher.has_event("two servers answer in this domain"); })) << said();
  const std::string told = text_of(folder_ / "palp-haptic-bridge.txt");
  EXPECT_NE(told.find("from sim_server " + first_name), std::string::npos) << told;
  EXPECT_NE(told.find("sim_server " + process_of(*second)), std::string::npos) << told;
  EXPECT_TRUE(watcher.sees([&] {
    return second->output().find("another sim_server " + first_name) != std::string::npos;
  })) << second->output();
  EXPECT_TRUE(watcher.sees([&] {
    return server_->output().find("another sim_server " + process_of(*second)) != std::string::npos;
  })) << server_->output();

  EXPECT_TRUE(watcher.sees([&] {
    return recorder->output().find("palp-record: 2 servers run in one domain") != std::string::npos;
  })) << recorder->output();

  const std::int64_t t_dead_ns = now_ns();
  server_->stop(SIGKILL);
  EXPECT_TRUE(watcher.sees([&] {
    return watcher.has_event("sim_server " + process_of(*second)) && watcher.has_event("takes its place");
  })) << said();
  watcher.status.clear();
  EXPECT_TRUE(force_is_felt(watcher)) << said();
  stop_bridge();
  EXPECT_EQ(second->stop(), 0) << second->output();
  EXPECT_EQ(recorder->stop(), 0) << recorder->output();
  ChildProcess info({kBin + "palp-info", folder_ / "run.mcap"}, folder_ / "info.txt");
  EXPECT_EQ(info.wait(), 0) << info.output();
  EXPECT_NE(info.output().find("2 servers spoke at one time"), std::string::npos) << info.output();

  const FlightTable log(folder_ / "flight.csv");
  std::size_t restarts = 0;
  for (std::size_t i = 0; i < log.ticks(); ++i) {
    const std::int64_t t = log.t_ns(i);
    if (t < t_second_ns || log.text("verdict", i) != "restarted") continue;
    ++restarts;
    EXPECT_GT(t, t_dead_ns) << "a sample of the second server came to use while the first one lived";
  }
  EXPECT_EQ(restarts, 1u);
}

INSTANTIATE_TEST_SUITE_P(Seconds, TwoOfAKind, testing::Values(Vendor::cyclone, Vendor::fastdds),
                         [](const auto& of) { return std::string(to_string(of.param)); });

}  // namespace
}  // namespace palp::test::two_of_a_kind_test
