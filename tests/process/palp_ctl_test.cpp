// palp-ctl against the real server, over either vendor.
#include <fmt/format.h>

#include "tests/process/running_system.h"

namespace palp::test::palp_ctl_test {
namespace {

struct Expected {
  std::vector<std::string> arguments;
  int status;
  std::string text;  // among what it says
};

class PalpCtl : public RunningSystem, public testing::WithParamInterface<Vendor> {
 protected:
  // Runs these side by side: each takes a second, to hear of every server.
  void expect(const std::vector<Expected>& calls) {
    std::vector<std::unique_ptr<ChildProcess>> running;
    for (const Expected& call : calls) {
      std::vector<std::string> command{kBin + "palp-ctl"};
      command.insert(command.end(), call.arguments.begin(), call.arguments.end());
      const std::vector<std::string> bus{"--dds", to_string(GetParam()), "--domain", std::to_string(domain_)};
      command.insert(command.end(), bus.begin(), bus.end());
      const std::string file = fmt::format("palp_ctl_{}.txt", running.size());
      running.push_back(std::make_unique<ChildProcess>(command, folder_ / file));
    }
    for (std::size_t i = 0; i < calls.size(); ++i) {
      SCOPED_TRACE(fmt::format("{}", fmt::join(calls[i].arguments, " ")));
      EXPECT_EQ(running[i]->wait(), calls[i].status) << running[i]->output();
      EXPECT_NE(running[i]->output().find(calls[i].text), std::string::npos) << running[i]->output();
    }
  }
  void expect(const std::vector<std::string>& arguments, int status, const std::string& text) {
    expect({{arguments, status, text}});
  }
};

TEST_P(PalpCtl, TellsWhoIsThereAndGivesCommands) {
  start_server();
  start_bridge();
  Watcher& watcher = watch();
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  const std::string server = "sim_server (process " + std::to_string(server_->pid()) + " on ";
  expect({{{"list"}, 0, server},
          {{"list"}, 0, "haptic_bridge 0 (process " + std::to_string(bridge_->pid()) + " on "},
          {{"list", "--json"}, 0, "\"real_time_factor\": "}});
  expect({"pause"}, 0, "paused");
  EXPECT_TRUE(watcher.sees([&] { return watcher.says("sim_server", "paused"); }));
  expect({"list"}, 0, "paused, x0.00 real time");
  EXPECT_TRUE(watcher.hears_news_of("sim_server"));
  const double steps = watcher.metric("sim_server", "steps");
  expect({"step"}, 0, "one step");
  EXPECT_TRUE(watcher.sees([&] { return watcher.metric("sim_server", "steps") == steps + 1; })) << "exactly one";
  EXPECT_TRUE(watcher.hears_news_of("sim_server"));
  EXPECT_EQ(watcher.metric("sim_server", "steps"), steps + 1);
  expect({"reset"}, 0, "reset");
  expect({"resume"}, 0, "running");

  expect({"get"}, 0, "material.oil.viscosity = 0.05 Pa s (0 to ");
  expect({{{"set", "material.oil.viscosity", "0.1"}, 0, "material.oil.viscosity is 0.1"},
          {{"set", "gravity", "0", "0", "-5"}, 0, "gravity is 0 0 -5"},
          {{"set", "stream.particle_rate_hz", "0"}, 0, "stream.particle_rate_hz is 0"}});
  expect({{{"get", "material.oil.viscosity"}, 0, "material.oil.viscosity = 0.1 Pa s"},
          {{"get", "gravity", "--json"}, 0, "\"value\": \"0 0 -5\""},
          {{"get"}, 0, "stream.particle_rate_hz = 0 Hz"},
          {{"get"}, 0, "stream.scalar = speed"},
          {{"get"}, 0, "numerics.density_diffusion = as the accuracy level derives it"}});
  expect({{{"set", "material.oil.viscosity", "-1"},
           1,
           "refused: parameter material.oil.viscosity is '-1', expected a number in Pa s from 0"},
          {{"get", "mud"}, 1, "refused: there is no parameter 'mud'"},
          {{"set", "gravity"}, 2, "value is required"},
          {{"fly"}, 2, ""},
          {{}, 2, "subcommand is required"},
          {{"--help"}, 0, "Exit status: 0 done, 1 refused or nobody answered, 2 bad usage."}});
  stop_bridge();
  expect({"quit"}, 0, "quitting");
  EXPECT_EQ(server_->wait(), 0) << said();
  expect({{{"pause", "--timeout", "1"}, 1, "no sim_server answered on " + std::string(to_string(GetParam()))},
          {{"list", "--listen", "1"}, 1, "nobody was heard on"}});
}

TEST_P(PalpCtl, GivesNoCommandToTwoServersUnlessItIsMeantForAll) {
  start_server();
  const auto second = start_tool("palp-sim-server", GetParam(), {kHere + "small_tray.toml", "--backend", "cpu"});
  Watcher& watcher = watch();
  ASSERT_TRUE(watcher.sees([&] { return watcher.has_event("another sim_server"); })) << said();
  expect({{{"pause"}, 1, "a command reaches all of them"}, {{"list"}, 0, "2 servers run in one domain"}});
  expect({"pause", "--all"}, 0, "(process " + std::to_string(second->pid()) + " on ");
  expect({"list"}, 0, "paused");
  expect({"quit", "--all"}, 0, "quitting");
  EXPECT_EQ(second->wait(), 0);
  EXPECT_EQ(server_->wait(), 0);
}

INSTANTIATE_TEST_SUITE_P(Vendors, PalpCtl, testing::Values(Vendor::cyclone, Vendor::fastdds),
                         [](const auto& of) { return std::string(to_string(of.param)); });

}  // namespace
}  // namespace palp::test::palp_ctl_test
