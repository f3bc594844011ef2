// Tests what palp-run does around a simulation, on one whose every step is known.
#include "tools/run_scene.h"

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <type_traits>

#include "config/error.h"
#include "tests/support/files.h"
#include "tests/support/scene_builder.h"
#include "tools/run_files.h"

namespace palp::test {
namespace {

// Particles that fall freely; the proxy is where its device is. Sick at the step that it is told.
class FreeFall : public Simulation {
 public:
  explicit FreeFall(Scene scene) : scene_(std::move(scene)) { output_.proxies.resize(scene_.proxies.size()); }
  const Scene& scene() const override { return scene_; }
  std::string backend_name() const override { return "none \"quoted\""; }
  std::string numerics() const override { return "exact"; }
  double support_radius() const override { return 3 * scene_.spacing; }
  int sub_steps() const override { return 1; }
  int fluid_interval() const override { return 1; }
  const StepOutput& output() const override { return output_; }
  void set_parameter(const std::string&, const std::string&) override {}
  const StepOutput& step(const StepInput& input) override {
    ++output_.step;
    output_.time = static_cast<double>(output_.step) / scene_.config.rate_hz;
    output_.bodies.resize(scene_.bodies.size());
    output_.bodies.back().state.position = {0, 0, 0.3};
    output_.bodies.back().state.linear = {2, 0, 0};
    for (std::size_t p = 0; p < output_.proxies.size(); ++p) {
      output_.proxies[p].state = input[p].state;
      output_.proxies[p].force = input[p].state.linear;
    }
    if (output_.step == sick_at) {
      output_.health.ok = false;
      output_.health.cause = "particle 7 left the world";
    }
    if (output_.step == doubtful_at) output_.health.doubt = "it is squeezed";
    if (output_.step == stop_at) stop = SIGINT;
    return output_;
  }
  void reset() override {
    output_.step = 0;
    output_.time = 0;
    ++resets;
  }
  void snapshot(Snapshot& out) override {
    out = {};
    out.time = output_.time;
    for (const Eigen::Vector3d& p : scene_.position) {
      const double z = p.z() - 5 * output_.time * output_.time;
      out.position.insert(out.position.end(),
                          {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(z)});
      out.velocity.insert(out.velocity.end(), {0, 0, static_cast<float>(-10 * output_.time)});
      out.density.push_back(500);
      out.pressure.push_back(1);
    }
    ++snapshots;
  }
  bool begin_frame(ScalarField) override { return false; }
  bool take_frame(Frame&) override { return false; }
  Footprint footprint() const override { return {}; }
  StageTimes time_stages(const StepInput&, double) override { return {}; }
  const std::vector<std::string>& warnings() const override { return warnings_; }

  std::uint64_t sick_at = 0, stop_at = 0, doubtful_at = 0;
  int resets = 0, snapshots = 0;
  std::atomic<int> stop{0};

 private:
  Scene scene_;
  StepOutput output_;
  std::vector<std::string> warnings_{"the wall is thin"};
};

class RunTest : public testing::Test {
 protected:
  RunTest() {
    SceneConfig config = scene(0.1);
    config.rate_hz = 100;
    config.duration = 0.5;
    config.numerics.solid_particles = true;
    config.bodies.push_back(body("water", BodyKind::fluid, box({0.5, 0.5, 0.5})));
    config.bodies.push_back(body("tool", BodyKind::rigid, box({0.2, 0.2, 0.2}, {0, 0, 0.6})));
    ProbeConfig front;
    front.name = "front";
    front.quantity = Quantity::front;
    front.axis = 2;
    front.rate_hz = 50;
    config.probes.push_back(front);
    ProxyConfig proxy;
    proxy.body = "tool";
    config.proxies.push_back(proxy);
    simulation_ = std::make_unique<FreeFall>(sample_scene(config, 10000));
    options_.out = folder_ / "out";
  }

  std::vector<std::string> lines(const std::string& name) {
    std::ifstream in(options_.out + "/" + name);
    std::vector<std::string> all;
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  }
  std::string file(const std::string& name) { return text_of(options_.out + "/" + name); }
  std::string write(const std::string& text) {
    write_text(folder_ / "path.csv", text);
    return folder_ / "path.csv";
  }

  const ScratchFolder folder_;
  std::unique_ptr<FreeFall> simulation_;
  RunOptions options_;
};

TEST_F(RunTest, WritesProbesSnapshotsAndSummary) {
  options_.snapshots_hz = 10;
  const RunResult result = run_scene(*simulation_, options_);
  EXPECT_TRUE(result.record.healthy());
  EXPECT_EQ(result.steps, 50u);
  EXPECT_NEAR(result.time, 0.5, 1e-12);
  EXPECT_EQ(simulation_->resets, 1);
  EXPECT_EQ(simulation_->snapshots, 26);
  const auto front = lines("front.csv");
  ASSERT_EQ(front.size(), 27u);
  EXPECT_EQ(front[1], "0,0.200000003");
  EXPECT_EQ(front[26].substr(0, 5), "0.5,-");
  EXPECT_EQ(lines("snapshots.csv"),
            (std::vector<std::string>{"snapshot,time_s", "0,0", "1,0.1", "2,0.2", "3,0.3", "4,0.4", "5,0.5"}));
  const auto particles = lines("particles_000005.csv");
  ASSERT_EQ(particles.size(), 125u + 8u + 1u);
  EXPECT_EQ(particles[0], "x,y,z,vx,vy,vz,density,pressure,body");
  EXPECT_NE(particles[1].find(",-5,500,1,water"), std::string::npos) << particles[1];
  EXPECT_NE(particles.back().find(",tool"), std::string::npos);
  const std::string summary = file("summary.json");
  EXPECT_NE(summary.find("\"steps\": 50,"), std::string::npos) << summary;
  EXPECT_NE(summary.find("\"backend\": \"none \\\"quoted\\\"\","), std::string::npos) << summary;
  EXPECT_NE(summary.find("\"healthy\": true"), std::string::npos);
  EXPECT_NE(summary.find("\"checked\": \"finite, nothing left the domain\""), std::string::npos) << summary;
  EXPECT_NE(summary.find("the wall is thin"), std::string::npos) << summary;
  EXPECT_FALSE(std::filesystem::exists(options_.out + "/proxy.csv"));
}

TEST_F(RunTest, StopsWhenUnhealthyAndKeepsWhatItHas) {
  simulation_->sick_at = 7;
  const RunResult result = run_scene(*simulation_, options_);
  EXPECT_FALSE(result.record.healthy());
  EXPECT_EQ(result.record.trouble(), "particle 7 left the world");
  EXPECT_EQ(result.steps, 7u);
  EXPECT_EQ(lines("front.csv").size(), 5u);
  EXPECT_NE(file("summary.json").find("\"cause\": \"particle 7 left the world\""), std::string::npos);
}

// A run whose answer is spoilt goes on to its end, and is not healthy.
TEST_F(RunTest, ASpoiltAnswerIsNotHealthy) {
  simulation_->doubtful_at = 7;
  const RunResult result = run_scene(*simulation_, options_);
  EXPECT_EQ(result.steps, 50u);
  EXPECT_FALSE(result.record.healthy());
  EXPECT_NE(file("summary.json").find("\"cause\": \"it is squeezed\""), std::string::npos);
}

TEST_F(RunTest, ADurationBelowOneStepIsRefused) {
  options_.duration = 0.009;
  EXPECT_THROW(run_scene(*simulation_, options_), ConfigError);
  options_.duration = 0.01;
  EXPECT_EQ(run_scene(*simulation_, options_).steps, 1u);
}

TEST_F(RunTest, StopsOnASignal) {
  simulation_->stop_at = 5;
  options_.stop = &simulation_->stop;
  const RunResult result = run_scene(*simulation_, options_);
  EXPECT_EQ(result.steps, 5u);
  EXPECT_EQ(result.stopped_by_signal, SIGINT);
  EXPECT_NE(file("summary.json").find("\"stopped_by_signal\": 2"), std::string::npos);
}

TEST_F(RunTest, DurationOfTheCommandLineWins) {
  options_.duration = 0.2;
  EXPECT_EQ(run_scene(*simulation_, options_).steps, 20u);
}

TEST_F(RunTest, APathDrivesDeviceZero) {
  options_.paths[0] = read_pose_path(write("time,x,y,z,qx,qy,qz,qw\n0.1,0,0,1,0,0,0,1\n0.3,2,0,1,0,0,1,0\n"));
  run_scene(*simulation_, options_);
  const auto proxy = lines("proxy.csv");
  ASSERT_EQ(proxy.size(), 51u);
  EXPECT_EQ(proxy[0].substr(0, 18), "time_s,x_m,y_m,z_m");
  // the step that ends at 0.21 s was given the pose of 0.2 s: half way, at 10 m/s
  EXPECT_EQ(proxy[21].substr(0, 11), "0.21,1,0,1,");
  EXPECT_NE(proxy[21].find(",10,0,0,"), std::string::npos) << proxy[21];
}

TEST_F(RunTest, EachDeviceHasAPathOfItsOwn) {
  SceneConfig config = simulation_->scene().config;
  config.bodies.push_back(body("fork", BodyKind::rigid, box({0.2, 0.2, 0.2}, {0, 0, 0.9})));
  ProxyConfig proxy;
  proxy.device = 3;
  proxy.body = "fork";
  config.proxies.push_back(proxy);
  simulation_ = std::make_unique<FreeFall>(sample_scene(config, 10000));
  options_.paths[3] = read_pose_path(write("time,x,y,z,qx,qy,qz,qw\n0,7,0,1,0,0,0,1\n"));
  options_.paths[0] = read_pose_path(write("time,x,y,z,qx,qy,qz,qw\n0,5,0,1,0,0,0,1\n"));
  run_scene(*simulation_, options_);
  EXPECT_EQ(lines("proxy.csv").at(21).substr(0, 11), "0.21,5,0,1,");
  EXPECT_EQ(lines("proxy_3.csv").at(21).substr(0, 11), "0.21,7,0,1,");
}

// The fluid, 62.5 kg, falls at 5 m/s; the tool, 4 kg, passes 0.9 m above the origin at 2 m/s.
TEST_F(RunTest, TotalsAreThoseOfAllThatMoves) {
  options_.totals_hz = 10;
  run_scene(*simulation_, options_);
  const auto rows = lines("totals.csv");
  ASSERT_EQ(rows.size(), 6u);
  std::istringstream names(rows[0]), cells(rows[5]);
  std::map<std::string, std::string> last;
  for (std::string name, cell; std::getline(names, name, ',') && std::getline(cells, cell, ',');) last[name] = cell;
  const auto value = [&](const std::string& name) { return std::stod(last.at(name)); };
  EXPECT_NEAR(value("time_s"), 0.5, 1e-9);
  EXPECT_NEAR(value("kinetic_J"), 62.5 * 25 / 2 + 4 * 4 / 2.0, 1e-3);
  EXPECT_NEAR(value("px_N_s"), 8, 1e-6);
  EXPECT_NEAR(value("pz_N_s"), -312.5, 1e-3);
  EXPECT_NEAR(value("Lx_N_m_s"), 0, 1e-3);
  EXPECT_NEAR(value("Ly_N_m_s"), 0.9 * 8, 1e-3);
  EXPECT_NEAR(value("volume_m3"), 0.125, 1e-6);
  EXPECT_TRUE(rows[0].ends_with(",penetration_m") && rows[5].ends_with(",0")) << rows[5];
  EXPECT_EQ(last.at("mean_temperature_K"), "");
}

// A StepTimes that owns no memory takes no more of it in a long run.
static_assert(std::is_trivially_destructible_v<StepTimes>);

TEST_F(RunTest, StepsAreTimedWithoutProbesAndFiles) {
  options_.snapshots_hz = 100;
  const RunResult result = run_scene(*simulation_, options_);
  const std::string summary = file("summary.json");
  const auto value = [&](const std::string& key) {
    const std::size_t at = summary.find('"' + key + "\": ");
    return at == std::string::npos ? -1 : std::stod(summary.substr(at + key.size() + 4));
  };
  EXPECT_GT(value("step_median_s"), 0);
  EXPECT_LE(value("step_median_s"), value("step_p90_s"));
  EXPECT_LE(value("step_p90_s"), value("step_p99_s"));
  EXPECT_LE(value("step_p99_s"), value("step_worst_s"));
  EXPECT_GT(value("step_cpu_median_s"), 0);
  EXPECT_NEAR(value("real_time_factor") * 100, value("reached_rate_hz"), 1e-6 * value("reached_rate_hz"));
  EXPECT_GT(value("reached_rate_hz"), static_cast<double>(result.steps) / result.wall_time);
}

TEST_F(RunTest, APathNeedsAProxy) {
  SceneConfig config = simulation_->scene().config;
  config.proxies.clear();
  simulation_ = std::make_unique<FreeFall>(sample_scene(config, 10000));
  options_.paths[0] = {{}};
  EXPECT_THROW(run_scene(*simulation_, options_), ConfigError);
}

TEST_F(RunTest, AFullDiskIsAnError) {
  std::filesystem::create_directories(options_.out);
  std::filesystem::create_symlink("/dev/full", options_.out + "/summary.json");
  EXPECT_THROW(run_scene(*simulation_, options_), std::runtime_error);
}

TEST_F(RunTest, PathsMoveAndTurnEvenly) {
  const std::vector<PathPose> path =
      read_pose_path(write("time,x,y,z,qx,qy,qz,qw\n# comment\n1,0,0,0,0,0,0,1\n\n3,2,4,6,0,0,1,0\n"));
  ASSERT_EQ(path.size(), 2u);
  const CouplingGains gains{1, 2, 3, 4};
  EXPECT_FALSE(device_on_path(path, 0.5, gains).engaged);
  const DeviceInput middle = device_on_path(path, 2, gains);
  EXPECT_TRUE(middle.engaged);
  EXPECT_EQ(middle.gains.angular_damping, 4);
  EXPECT_LT((middle.state.position - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((middle.state.linear - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_NEAR(std::abs(middle.state.angular.z()), EIGEN_PI / 2, 1e-9);
  const Eigen::Vector3d turned = middle.state.orientation * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(std::abs(turned.y()), 1, 1e-9);
  EXPECT_GT(turned.y() * middle.state.angular.z(), 0);  // it turns the way that its twist says
  const DeviceInput end = device_on_path(path, 9, gains);
  EXPECT_TRUE(end.engaged);
  EXPECT_EQ(end.state.position, Eigen::Vector3d(2, 4, 6));
  EXPECT_EQ(end.state.linear, Eigen::Vector3d(0, 0, 0));
}

TEST_F(RunTest, PathsBeginAnewWhereTheyEnd) {
  const std::vector<PathPose> path =
      read_pose_path(write("time,x,y,z,qx,qy,qz,qw\n1,0,0,0,0,0,0,1\n2,1,0,0,0,0,0,1\n4,0,0,0,0,0,0,1\n"));
  const std::pair<double, double> expected[] = {{0.5, 0.5}, {1, 1}, {3.5, 3.5}, {4.25, 1.25}, {7.5, 1.5}, {12, 3}};
  for (const auto& [time, on_path] : expected) EXPECT_NEAR(repeated(path, time), on_path, 1e-12) << time;
  const std::vector<PathPose> one = read_pose_path(write("time,x,y,z,qx,qy,qz,qw\n1,0,0,0,0,0,0,1\n"));
  EXPECT_EQ(repeated(one, 9), 9);
}

TEST_F(RunTest, ProgressInALogIsLinesThatSayWhatIsLeft) {
  options_.progress = ProgressOn::log;
  options_.progress_period = 0;
  testing::internal::CaptureStderr();
  run_scene(*simulation_, options_);
  std::istringstream said(testing::internal::GetCapturedStderr());
  int lines = 0;
  for (std::string line; std::getline(said, line); ++lines) {
    EXPECT_NE(line.find(" s left"), std::string::npos) << line;
    EXPECT_EQ(line.find('\r'), std::string::npos) << line;
  }
  EXPECT_EQ(lines, 50);
  options_.progress_period = 10;
  testing::internal::CaptureStderr();
  run_scene(*simulation_, options_);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");  // it ends before the first is due
}

}  // namespace
}  // namespace palp::test
