// Files that a person or a disk has spoilt: profiles, hands, scripts of the simulated Virtuose, replayed paths. Each is
// read or refused with ConfigError; what is read is sound enough to run.
#include <algorithm>
#include <filesystem>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "config/error.h"
#include "haptic_bridge/device/fake_virtuose/script.h"
#include "haptic_bridge/device/profile.h"
#include "haptic_bridge/device/replay.h"
#include "haptic_bridge/device/virtuose/session.h"
#include "haptic_bridge/loop/local_model.h"
#include "tests/support/files.h"
#include "tests/support/seed.h"

namespace palp::test::hostile_files_test {
namespace {

namespace fs = std::filesystem;

// Cut short, with bytes changed, lines lost, doubled or swapped, numbers that are none.
std::string spoilt(std::string text, std::mt19937& random) {
  static const std::vector<std::string> kNumbers{
      "nan",  "inf", "-inf", "1e400", "-1",  "0",  "1e308",       "-1e-320",
      "\"\"", "[]",  "{}",   "true",  "0x7", "''", "[nan, 0, 0]", "99999999999999999999"};
  static const std::string kBytes = "=\"[]{}#,.-\n\r\t\\'0123456789abcxyz\xff\x80";
  for (unsigned edits = 1 + random() % 4; edits > 0 && !text.empty(); --edits) {
    const std::size_t at = random() % text.size();
    switch (random() % 6) {
      case 0:
        text.resize(at);
        break;
      case 1:
        text[at] = kBytes[random() % kBytes.size()];
        break;
      case 2:
        text.erase(at, 1 + random() % 30);
        break;
      case 3: {  // a line twice
        const std::size_t end = text.find('\n', at);
        text.insert(at, text.substr(at, end == std::string::npos ? end : end - at + 1));
        break;
      }
      default: {  // a value
        const std::size_t begin = text.find_first_of("=,", at);
        if (begin == std::string::npos) break;
        const std::size_t end = text.find_first_of(",\n#", begin + 1);
        text.replace(begin + 1, end == std::string::npos ? end : end - begin - 1,
                     " " + kNumbers[random() % kNumbers.size()]);
      }
    }
  }
  return text;
}

class HostileFiles : public ::testing::Test {
 protected:
  // Spoils each of the texts again and again and reads it; use: of what was read.
  void spoil(const std::vector<std::string>& texts, const std::function<void(const std::string& path)>& read) {
    SCOPED_TRACE("seed " + std::to_string(seed_));
    std::mt19937 random(seed_);
    int refused = 0;
    const int rounds = 400;
    for (int i = 0; i < rounds; ++i) {
      const std::string path = folder_ / "file";
      const std::string text = spoilt(texts[static_cast<std::size_t>(i) % texts.size()], random);
      write_text(path, text);
      try {
        read(path);
      } catch (const ConfigError& error) {
        ++refused;
        EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
      } catch (const std::exception& error) {
        ADD_FAILURE() << "another kind of error: " << error.what() << "\n" << text;
      }
      if (HasFailure()) return;
    }
    EXPECT_GT(refused, rounds / 2);
  }
  static std::vector<std::string> files_in(const std::string& folder) {
    std::vector<std::string> texts;
    for (const auto& entry : fs::directory_iterator(PALP_SOURCE_DIR "/config/" + folder))
      if (entry.path().extension() == ".toml") texts.push_back(text_of(entry.path()));
    std::sort(texts.begin(), texts.end());
    return texts;
  }

  const ScratchFolder folder_;
  const unsigned seed_ = drawn_seed();
};

TEST_F(HostileFiles, Profiles) {
  spoil(files_in("devices"), [](const std::string& path) {
    const DeviceProfile p = read_device_profile(path);
    const LoopConfig c = p.loop;
    for (const double x : {c.limits.force, c.limits.torque, c.limits.force_slew, c.limits.torque_slew, c.limits.power})
      EXPECT_TRUE(std::isfinite(x) && x > 0) << x;
    EXPECT_LE(c.limits.force, 200);
    EXPECT_TRUE(std::isfinite(c.gains.stiffness) && c.gains.stiffness >= 0);
    EXPECT_TRUE(is_finite(c.limits.axis_force) && c.limits.axis_force.minCoeff() > 0);
    EXPECT_TRUE(c.workspace.motion_scale > 0 && c.workspace.force_scale > 0);
    EXPECT_NEAR(p.setup<VirtuoseSetup>().axes.determinant(), 1, 1e-6);
  });
}

TEST_F(HostileFiles, Hands) {
  const RigidState home = at_rest(Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());
  spoil(files_in("hands"), [&](const std::string& path) {
    const HandScript script = read_hand_script(path);
    SimulatedDevice arm(ArmModel{}, script, home, home);
    DeviceReading reading;
    for (std::int64_t t = 0; t < 50; ++t) {
      EXPECT_TRUE(arm.read(20'000'000 * t, reading));
      EXPECT_TRUE(is_finite(reading.state));
    }
  });
}

TEST_F(HostileFiles, ScriptsOfTheSimulatedVirtuose) {
  const std::string script =
      "clock = \"lock_step\"\ngrip_at = 0.1\nrelay_delay = 0.2\nlatency = 0.001\nregrip = false\ndevice_type = 3\n"
      "workspace = [0.1, 0.2, 0.3]\ncontinuous_force = 3\n[[event]]\nevent = \"slow\"\ntime = 0.1\nduration = 0.2\n"
      "value = 0.01\ncall = \"virtGetSpeed\"\n[[event]]\nevent = \"alarm\"\ntime = 1\nvalue = 16384\n";
  spoil({script}, [](const std::string& path) {
    const fake::Script s = fake::read_script(path);
    EXPECT_TRUE(s.latency >= 0 && s.latency <= 0.1);
    for (const fake::Event& event : s.events) EXPECT_TRUE(std::isfinite(event.time) && event.end >= event.time);
  });
}

TEST_F(HostileFiles, Paths) {
  const std::string path_text =
      "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n0.5,0.1,0,0,0,0,0.70710678,0.70710678\n1,0,0,0,0,0,0,1\n";
  spoil({path_text}, [](const std::string& path) {
    ReplayDevice device(path, false);
    DeviceReading reading;
    for (std::int64_t t = 0; t < 20; ++t) {
      EXPECT_TRUE(device.read(100'000'000 * t, reading));
      EXPECT_TRUE(is_finite(reading.state.position) && is_unit(reading.state.orientation));
    }
  });
}

}  // namespace
}  // namespace palp::test::hostile_files_test
