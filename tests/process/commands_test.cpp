// Commands to the real server over the bus, by a client of either vendor: replies come and the state follows.
#include "tests/process/running_system.h"

namespace palp::test::commands_test {
namespace {

class Commands : public RunningSystem, public testing::WithParamInterface<Vendor> {
 protected:
  void SetUp() override {
    start_server();
    watcher_ = &watch(GetParam());
    client_ = std::make_unique<Client>(watcher_->bus());
    ASSERT_TRUE(client_->reaches_server()) << said();
    ASSERT_TRUE(watcher_->sees([&] { return watcher_->says("sim_server", "running"); })) << said();
  }

  CommandReply ask(CommandKind kind, const std::string& name = {}, const std::string& value = {}) {
    CommandReply reply = client_->ask(kind, name, value);
    EXPECT_FALSE(reply.text.empty()) << "nobody answered\n" << said();
    return reply;
  }
  bool refuses(CommandKind kind, const std::string& name, const std::string& value, const std::string& why) {
    const CommandReply reply = ask(kind, name, value);
    EXPECT_NE(reply.text.find(why), std::string::npos) << reply.text;
    return !reply.ok;
  }
  double steps() { return watcher_->metric("sim_server", "steps"); }

  Watcher* watcher_ = nullptr;
  std::unique_ptr<Client> client_;
};

TEST_P(Commands, PauseStepResumeReset) {
  EXPECT_TRUE(refuses(CommandKind::step, "", "", "pause first"));
  EXPECT_TRUE(ask(CommandKind::pause).ok);
  EXPECT_TRUE(watcher_->sees([&] { return watcher_->says("sim_server", "paused"); }));
  EXPECT_TRUE(watcher_->sees([&] { return (watcher_->proxy.flags & kPaused) != 0; }));
  EXPECT_TRUE(watcher_->hears_news_of("sim_server"));
  const double paused_at = steps();
  const double paused_time = watcher_->proxy.sim_time;
  EXPECT_TRUE(watcher_->hears_news_of("sim_server"));
  EXPECT_EQ(steps(), paused_at);
  EXPECT_EQ(watcher_->proxy.sim_time, paused_time);

  EXPECT_TRUE(ask(CommandKind::step).ok);
  EXPECT_TRUE(ask(CommandKind::step).ok);
  EXPECT_TRUE(watcher_->sees([&] { return steps() >= paused_at + 2; })) << said();
  EXPECT_TRUE(watcher_->hears_news_of("sim_server"));
  EXPECT_EQ(steps(), paused_at + 2);
  EXPECT_NEAR(watcher_->proxy.sim_time, paused_time + 0.002, 1e-9);

  EXPECT_TRUE(ask(CommandKind::reset).ok);
  EXPECT_TRUE(watcher_->sees([&] { return watcher_->proxy.sim_time == 0; })) << said();
  EXPECT_TRUE(watcher_->says("sim_server", "paused"));
  EXPECT_TRUE(ask(CommandKind::resume).ok);
  EXPECT_TRUE(watcher_->sees([&] {
    return watcher_->says("sim_server", "running") && (watcher_->proxy.flags & kPaused) == 0 &&
           watcher_->proxy.sim_time > 0.2;
  })) << said();
  stop_server();
}

TEST_P(Commands, ParametersAreSetOrRefusedAndQuitEndsTheServer) {
  EXPECT_TRUE(ask(CommandKind::set_parameter, "gravity", "0 0 -5").ok);
  EXPECT_TRUE(ask(CommandKind::set_parameter, "material.oil.viscosity", "0.1").ok);
  EXPECT_TRUE(ask(CommandKind::set_parameter, "stream.scalar", "density").ok);
  EXPECT_NE(ask(CommandKind::get_parameter, kBillName).text.find("\nModules\n"), std::string::npos);
  EXPECT_TRUE(refuses(CommandKind::set_parameter, "gravity", "down", "expected 3 numbers, each a number in m/s^2"));
  EXPECT_TRUE(refuses(CommandKind::set_parameter, "gravity", "0 0 nan", "expected 3 numbers, each a number in m/s^2"));
  EXPECT_TRUE(
      refuses(CommandKind::set_parameter, "material.oil.viscosity", "-1", "expected a number in Pa s from 0 to"));
  EXPECT_TRUE(refuses(CommandKind::set_parameter, "material.mud.viscosity", "1", "there is no parameter"));
  EXPECT_TRUE(
      refuses(CommandKind::set_parameter, "stream.particle_rate_hz", "fast", "expected a number in Hz from 0 to 1000"));
  EXPECT_TRUE(refuses(CommandKind::set_parameter, "", "", "there is no parameter"));
  // the particles now carry the field that was asked for
  const auto particles = watcher_->bus().reader<ParticleChunk>();
  Received<ParticleChunk> chunk;
  EXPECT_TRUE(watcher_->sees([&] {
    return particles->take_latest(chunk) && chunk.message.field == ScalarField::density;
  })) << said();
  EXPECT_TRUE(watcher_->says("sim_server", "running"));

  EXPECT_TRUE(ask(CommandKind::quit).ok);
  EXPECT_EQ(server_->wait(), 0) << said();
  EXPECT_NE(summary("palp-sim-server").find("\"healthy\": true"), std::string::npos) << summary("palp-sim-server");
}

// Another scene is served as by a server that was started anew.
TEST_P(Commands, GoesOverToAnotherSceneAndReadsItAnew) {
  const std::string names = "\n" + ask(CommandKind::get_parameter, kScenesName).text + "\n";
  EXPECT_NE(names.find("\ntray_rigid\n"), std::string::npos) << names;
  EXPECT_TRUE(refuses(CommandKind::load_scene, "no_such_scene", "", "there is no scene 'no_such_scene'"));
  EXPECT_TRUE(refuses(CommandKind::load_scene, "../../etc/passwd", "", "expected one of"));
  EXPECT_TRUE(watcher_->says("sim_server", "running")) << "what is refused changes nothing";

  const auto scenes = watcher_->bus().reader<SceneDescription>();
  Received<SceneDescription> scene;
  ASSERT_TRUE(watcher_->sees([&] { return scenes->take_latest(scene); }));
  const std::string first = scene.message.name;
  const auto serves = [&](const std::string& name, std::uint64_t not_session) {
    return watcher_->sees([&] {
      scenes->take_latest(scene);
      return scene.message.name == name && scene.message.header.session != not_session &&
             watcher_->says("sim_server", "running");
    });
  };
  std::uint64_t session = scene.message.header.session;
  EXPECT_NE(ask(CommandKind::load_scene, "tray_rigid").text.find("'tray_rigid' follows"), std::string::npos);
  EXPECT_TRUE(serves("tray_rigid", session)) << first << "\n" << said();
  session = scene.message.header.session;
  ASSERT_TRUE(client_->reaches_server()) << said();
  EXPECT_NE(ask(CommandKind::load_scene).text.find("'tray_rigid' follows"), std::string::npos);
  EXPECT_TRUE(serves("tray_rigid", session)) << said();
  stop_server();
}

TEST_P(Commands, ADivergedSimulationSaysWhyAndRunsAgainAfterReset) {
  EXPECT_TRUE(ask(CommandKind::set_parameter, "body_force", "1000 0 0").ok);
  EXPECT_TRUE(watcher_->sees([&] {
    return watcher_->says("sim_server", "fault") && (watcher_->proxy.flags & kHealthy) == 0 &&
           watcher_->has_event("the simulation stopped");
  })) << said();
  EXPECT_EQ(watcher_->proxy.wrench, WrenchD{});
  EXPECT_TRUE(refuses(CommandKind::resume, "", "", "reset or quit"));
  EXPECT_TRUE(ask(CommandKind::set_parameter, "body_force", "0 0 0").ok);
  EXPECT_TRUE(ask(CommandKind::reset).ok);
  EXPECT_TRUE(watcher_->sees([&] {
    return watcher_->says("sim_server", "running") && (watcher_->proxy.flags & kHealthy) != 0 &&
           watcher_->proxy.sim_time > 0.3;
  })) << said();
  EXPECT_EQ(server_->stop(), 3) << "a run that had a fault is not a healthy one";
  EXPECT_NE(summary("palp-sim-server").find("\"healthy\": false"), std::string::npos) << summary("palp-sim-server");
  EXPECT_EQ(summary("palp-sim-server").find("\"cause\": \"\""), std::string::npos) << summary("palp-sim-server");
}

INSTANTIATE_TEST_SUITE_P(Clients, Commands, testing::Values(Vendor::cyclone, Vendor::fastdds),
                         [](const auto& of) { return std::string(to_string(of.param)); });

}  // namespace
}  // namespace palp::test::commands_test
