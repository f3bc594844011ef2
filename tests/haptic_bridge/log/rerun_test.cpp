// A run that was kept is run again from its file and gives the same wrenches, states and gains, bit for bit.
#include "haptic_bridge/log/rerun.h"

#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "config/error.h"
#include "haptic_bridge/device/replay.h"
#include "haptic_bridge/device/simulated.h"
#include "haptic_bridge/device/virtuose.h"
#include "haptic_bridge/run.h"
#include "tests/haptic_bridge/loop/fake_server.h"
#include "tests/support/files.h"
#include "tests/support/seed.h"

namespace palp::test::rerun_test {
namespace {

constexpr std::int64_t kStart = 5'000'000'000;

const RigidState kHome = at_rest({0.1, 0.2, -0.004}, Eigen::Quaterniond::Identity());

double seconds(std::int64_t now_ns) { return 1e-9 * static_cast<double>(now_ns - kStart); }

// A device, and around it a server and all that goes wrong, by the time of the run:
//   1.5 s no reading for 3 ticks, 2 s dead-man open, 3 s shifted, 4 s a slow link, 5 s unsound samples, 6 s silence,
//   7 s a server that was started again, 8 s a write that fails, 8.5 s strained
class TroubledDevice final : public HapticDevice {
 public:
  TroubledDevice(HapticDevice& device, LoopPorts& ports) : device_(device), ports_(ports) {}
  const DeviceInfo& info() const noexcept override { return device_.info(); }
  void show(LoopState state) noexcept override { device_.show(state); }
  bool read(std::int64_t now, DeviceReading& out) noexcept override {
    const double t = seconds(now);
    serve(now, t);
    const bool good = device_.read(now, out);
    if (within(t, 2, 2.05)) out.dead_man = false;
    out.shifted = within(t, 3, 3.2);
    out.strained = within(t, 8.5, 8.6);
    if (within(t, 1.5, 1.503)) out.state.linear.x() = std::nan("");
    return good && !within(t, 1.51, 1.513);
  }
  bool write(const Wrench<double>& w) noexcept override {
    return device_.write(w) && !within(seconds(last_), 8, 8.003);
  }

 private:
  static bool within(double t, double from, double to) { return t >= from && t < to; }
  void serve(std::int64_t now, double t) {
    DeviceSample device;
    last_ = now;
    if (!ports_.outgoing.take(device)) return;
    waiting_.push_back(device);
    const std::size_t delay = within(t, 4, 4.5) ? 60 : 1;  // ticks
    if (waiting_.size() < delay || within(t, 6, 6.15)) return;
    while (waiting_.size() > delay) waiting_.pop_front();
    const std::uint64_t session = t < 7 ? 5 : 6;
    if (session != session_) sequence_ = 0;
    session_ = session;
    IncomingProxy in{answer(waiting_.front(), session, ++sequence_), now};
    SpringWall{}.touch(in.sample);
    in.sample.energy = {1e-6 * static_cast<double>(sequence_ % 7), 0};
    if (within(t, 5, 5.01)) in.sample.wrench.force[1] = std::nan("");
    if (within(t, 5.6, 5.61)) ports_.refused.fetch_add(2);
    ports_.incoming.put(in);
  }

  HapticDevice& device_;
  LoopPorts& ports_;
  std::deque<DeviceSample> waiting_;
  std::uint64_t session_ = 0, sequence_ = 0;
  std::int64_t last_ = kStart;
};

// A clock that is mostly in time and sometimes late by a few periods.
class UnsteadyClock final : public Clock {
 public:
  explicit UnsteadyClock(unsigned seed) : random_(seed) {}
  std::int64_t now_ns() noexcept override { return now_; }
  void sleep_until(std::int64_t t) noexcept override {
    now_ = std::max(now_, t) + static_cast<std::int64_t>(random_() % 90'000);
    if (random_() % 2000 == 0) now_ += static_cast<std::int64_t>(random_() % 8'000'000);
  }

 private:
  std::mt19937 random_;
  std::int64_t now_ = kStart;
};

class RunAgain : public ::testing::Test {
 protected:
  // Runs the loop with this device and returns the path of the run's file.
  std::string keep(HapticDevice& device, std::size_t ticks = 9000, std::size_t room = 9000) {
    LoopConfig config;
    config.own_session = kBridgeSession;
    config.limits = {8, 0.5, 300, 30, {7, 8, 6}, {0.5, 0.4, 0.5}, 3, 0.2, 4};
    config.workspace = {1.5, 0.8, true};
    const auto ports = std::make_unique<LoopPorts>();
    TroubledDevice troubled(device, *ports);
    HapticLoop loop(config, troubled);
    FlightLog log(room);
    UnsteadyClock clock(seed_);
    const std::atomic<bool> stop{false};
    run_loop(loop, clock, *ports, log, stop, ticks);
    for (std::size_t i = 0; i < log.size(); ++i) {
      states_.insert(log.at(i).state);
      lowered_ = lowered_ || log.at(i).gains_share < 1;
      late_ = late_ || log.at(i).missed > 0;
    }
    felt_ = std::max(felt_, loop.report().peak_force);
    trips_ += loop.report().trips;
    std::string path = folder_ / "run.ticks";
    write_ticks(log, loop.config(), path);
    return path;
  }
  // Expects each of several runs to be the same when it is run again, and all together to have seen everything.
  void expect_same(const std::function<std::unique_ptr<HapticDevice>()>& make) {
    for (const unsigned first = seed_; seed_ != first + 8; ++seed_) {
      SCOPED_TRACE("seed " + std::to_string(seed_));
      const Rerun rerun = run_again(read_ticks(keep(*make())));
      ASSERT_EQ(to_text(rerun), "9000 ticks, identical");
      ASSERT_EQ(rerun.differs_at, 0u);
    }
    SCOPED_TRACE("seeds up to " + std::to_string(seed_ - 1));
    for (const LoopState state : {LoopState::waiting, LoopState::ready, LoopState::engaged, LoopState::idle,
                                  LoopState::degraded, LoopState::stale, LoopState::locked})
      EXPECT_TRUE(states_.contains(state)) << palp::to_string(state);
    EXPECT_TRUE(lowered_ && late_);
    EXPECT_GT(trips_, 0u);
    EXPECT_GT(felt_, 0.3);
  }

  const ScratchFolder folder_;
  unsigned seed_ = drawn_seed();
  std::set<LoopState> states_;
  bool lowered_ = false, late_ = false;
  double felt_ = 0;
  std::uint64_t trips_ = 0;
};

HandScript pressing_hand() {
  HandScript hand;
  hand.keyframes = {{0, {0, 0, 0}}, {1, {0, 0, -0.003}}, {2, {0.03, 0, 0.002}}, {3, {0, 0, 0}}};
  hand.loop = true;
  hand.hand.noise = 0.1;
  return hand;
}

TEST_F(RunAgain, TheSimulatedArmsRunIsTheSameBitForBit) {
  expect_same([] { return std::make_unique<SimulatedDevice>(ArmModel{}, pressing_hand(), kHome, kHome); });
}

TEST_F(RunAgain, TheVirtuosesRunIsTheSameBitForBit) {
  std::ofstream(folder_ / "hand.toml") << "grip = \"firm\"\nloop = true\n[[keyframe]]\ntime = 0\n[[keyframe]]\n"
                                          "time = 1\nposition = [0, 0, -0.003]\n[[keyframe]]\ntime = 2\n";
  std::ofstream(folder_ / "arm.toml")
      << "clock = \"lock_step\"\ngrip_at = 0.1\nrelay_delay = 0\nhand = \"hand.toml\"\n";
  VirtuoseSetup setup;
  setup.library = PALP_LIB_DIR "/libvirtuose_sim.so";
  setup.address = folder_ / "arm.toml";
  setup.relay_time = 0.05;
  setup.limits = {10, 1, 300, 30};
  expect_same([&] { return std::make_unique<VirtuoseDevice>(setup, kHome); });
}

TEST_F(RunAgain, AReplayedPathsRunIsTheSameBitForBit) {
  std::ofstream(folder_ / "path.csv") << "time,x,y,z,qx,qy,qz,qw\n0,0,0,-0.001,0,0,0,1\n1,0,0,-0.004,0,0,0,1\n"
                                         "2,0.03,0,0.002,0,0,0,1\n3,0,0,-0.001,0,0,0,1\n";
  expect_same([&] { return std::make_unique<ReplayDevice>(folder_ / "path.csv", true); });
}

// Returns the index of a tick in which the hand presses and the force changes more slowly than its slope limit, so that
// it follows the place; 0 where there is none.
std::size_t pressed_tick(const KeptRun& run) {
  for (std::size_t k = 2300; k < run.results.size(); ++k) {
    const TickResult &now = run.results[k], &before = run.results[k - 1];
    if (now.state == LoopState::engaged && now.sent.force.z() > 0.5 &&
        (now.sent.force - before.sent.force).norm() < 0.01)
      return k;
  }
  return 0;
}

TEST_F(RunAgain, ASmallChangeOfAnInputIsFound) {
  KeptRun run;
  std::size_t at = 0;
  for (const unsigned first = seed_; at == 0 && seed_ != first + 20; ++seed_) {
    SimulatedDevice arm(ArmModel{}, pressing_hand(), kHome, kHome);
    run = read_ticks(keep(arm));
    at = pressed_tick(run);
  }
  SCOPED_TRACE("seed " + std::to_string(seed_ - 1));
  ASSERT_GT(at, 0u);
  double& x = run.inputs[at].reading.state.position.x();
  const double was = x;
  x += 1e-12;
  const Rerun rerun = run_again(run);
  EXPECT_EQ(rerun.differs_at, at + 1);
  EXPECT_NE(to_text(rerun).find("differs\n  then  engaged, force "), std::string::npos) << to_text(rerun);
  x = was;
  EXPECT_EQ(run_again(run).differs_at, 0u);
  run.results[at].state = LoopState::idle;
  EXPECT_EQ(run_again(run).differs_at, at + 1);
}

TEST_F(RunAgain, ALogThatLacksTheBeginningIsRefused) {
  SimulatedDevice arm(ArmModel{}, pressing_hand(), kHome, kHome);
  const KeptRun run = read_ticks(keep(arm, 500, 300));
  EXPECT_EQ(run.first_tick, 201u);
  EXPECT_EQ(run.inputs.size(), 300u);
  try {
    run_again(run);
    FAIL() << "it was run";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("--log-seconds"), std::string::npos) << error.what();
  }
}

// With times that no clock shows, the loop's differences would overflow.
TEST_F(RunAgain, TimesThatCannotBeAreRefused) {
  SimulatedDevice arm(ArmModel{}, pressing_hand(), kHome, kHome);
  const std::string path = keep(arm, 40, 40);
  const std::string whole = text_of(path);
  const std::int64_t now = read_ticks(path).inputs[20].now_ns;
  const std::size_t word = sizeof now;
  const std::size_t tick = whole.find(std::string(reinterpret_cast<const char*>(&now), word));
  ASSERT_NE(tick, std::string::npos);
  // the period follows magic word, number of ticks and first tick; lateness follows the time
  for (const std::size_t at : {3 * word, tick, tick + word}) {
    using Limits = std::numeric_limits<std::int64_t>;
    for (const std::int64_t time : {Limits::min(), Limits::max()}) {
      std::string bytes = whole;
      bytes.replace(at, word, reinterpret_cast<const char*>(&time), word);
      write_text(path, bytes);
      EXPECT_THROW(read_ticks(path), ConfigError) << time << " at " << at;
    }
  }
}

// Bytes that lie: each is refused in one sentence, or is a run like any other.
TEST_F(RunAgain, DamagedFilesAreRefusedOrReadAndNeverCrash) {
  SimulatedDevice arm(ArmModel{}, pressing_hand(), kHome, kHome);
  const std::string path = keep(arm, 40, 40);
  const std::string whole = text_of(path);
  ASSERT_NO_THROW(read_ticks(path));
  SCOPED_TRACE("seed " + std::to_string(seed_));
  std::mt19937 random(seed_);
  int refused = 0;
  for (int i = 0; i < 400; ++i) {
    std::string bytes = whole;
    if (i % 4 == 0) {
      bytes.resize(random() % bytes.size());
    } else if (i % 4 == 1) {
      bytes.append(1 + random() % 30, 'x');
    } else {
      for (unsigned n = 1 + random() % 8; n > 0; --n) {
        const std::size_t most = i % 4 == 2 ? 900 : bytes.size();  // its head counts most
        bytes[random() % most] = static_cast<char>(random());
      }
    }
    write_text(path, bytes);
    try {
      KeptRun run = read_ticks(path);
      run.first_tick = 1;
      run_again(run);
    } catch (const ConfigError& error) {
      ++refused;
      EXPECT_EQ(std::string(error.what()).find(path), 0u) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(refused, 200);
  EXPECT_THROW(read_ticks(folder_ / "nowhere"), ConfigError);
  EXPECT_THROW(read_ticks("/dev/zero"), ConfigError);
}

}  // namespace
}  // namespace palp::test::rerun_test
