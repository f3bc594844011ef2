// Profiles of devices: those that are shipped, and those that are wrong.
#include "haptic_bridge/device/profile.h"

#include <algorithm>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "haptic_bridge/device/simulated.h"
#include "haptic_bridge/device/virtuose/session.h"
#include "tests/haptic_bridge/device/device_files.h"
#include "tests/haptic_bridge/device/poses.h"

namespace palp::test::profile_test {
namespace {

using Profiles = DeviceFiles;

TEST_F(Profiles, TheShippedFilesAreReadAndSayWhatTheyShould) {
  const std::string config = PALP_SOURCE_DIR "/config/";
  const DeviceProfile profile = read_device_profile(config + "devices/simulated.toml");
  EXPECT_EQ(profile.loop.limits.force, 35);
  EXPECT_EQ(profile.loop.limits.torque, 3);
  EXPECT_EQ(profile.loop.gains, DeviceProfile{}.loop.gains);
  EXPECT_EQ(profile.setup<ArmModel>().mass, ArmModel{}.mass);
  EXPECT_EQ(profile.setup<ArmModel>().resolution, ArmModel{}.resolution);
  for (const char* name : {"still", "stir", "press"}) {
    const HandScript script = read_hand_script(config + "hands/" + name + ".toml");
    EXPECT_EQ(script.keyframes.front().x.norm(), 0) << name;
    SimulatedDevice device(profile.setup<ArmModel>(), script, kOrigin, kOrigin);
    double fastest = 0;
    for (double t = 0; t < 12; t += 1e-3) fastest = std::max(fastest, device.intent(t).linear.norm());
    EXPECT_LT(fastest, 0.5) << name;
  }
}

TEST_F(Profiles, TheShippedVirtuosesAskForTheirArmAndForNoMoreThanItHolds) {
  const std::string folder = PALP_SOURCE_DIR "/config/devices/virtuose_";
  for (const auto& [name, type, force, torque] :
       {std::tuple{"6d", 3, 10.0, 1.0}, {"6d_desktop", 4, 3.0, 0.2}, {"6d_tao", 0, 30.0, 1.5}, {"sim", 3, 10.0, 1.0}}) {
    SCOPED_TRACE(name);
    const DeviceProfile profile = read_device_profile(folder + name + ".toml");
    EXPECT_TRUE(profile.setup<VirtuoseSetup>().in_profile);
    EXPECT_EQ(profile.setup<VirtuoseSetup>().device_type.value_or(0), type);
    EXPECT_EQ(profile.loop.limits.force, force);
    EXPECT_EQ(profile.loop.limits.torque, torque);
    EXPECT_EQ(profile.setup<VirtuoseSetup>().mode, VirtuoseMode::impedance);
    EXPECT_EQ(profile.setup<VirtuoseSetup>().axes, default_arm_axes());
    EXPECT_EQ(profile.setup<VirtuoseSetup>().relay_time, 3);
    EXPECT_TRUE(profile.loop.workspace.relative);
  }
  EXPECT_FALSE(read_device_profile(PALP_SOURCE_DIR "/config/devices/simulated.toml").setup<VirtuoseSetup>().in_profile);
}

TEST_F(Profiles, AxesAreARotationThatMayBeTurned) {
  const std::string head = "name = \"x\"\n[limits]\n[axes]\n";
  const DeviceProfile turned = read_device_profile(write(head + "x = \"-y\"\ny = \"+x\"\nz = \"+z\"\nturn_deg = 90\n"));
  EXPECT_LT((turned.setup<VirtuoseSetup>().axes - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  const std::vector<std::pair<std::string, std::string>> cases{
      {"x = \"+x\"\ny = \"+x\"\nz = \"+z\"\n", ":3: "},
      {"x = \"+y\"\ny = \"+x\"\nz = \"+z\"\n", "right-handed"},
      {"x = \"up\"\ny = \"+x\"\nz = \"+z\"\n", ":4: "},
      {"x = \"-y\"\ny = \"+x\"\n", "z"},
      {"x = \"-y\"\ny = \"+x\"\nz = \"+z\"\nturn_deg = 900\n", ":7: "},
      {"x = \"-y\"\ny = \"+x\"\nz = \"+z\"\n[virtuose]\nmode = \"admittance\"\n", ":8: "},
      {"x = \"-y\"\ny = \"+x\"\nz = \"+z\"\n[virtuose]\ndevice = 3\n", ":8: "},
      {"x = \"-y\"\ny = \"+x\"\nz = \"+z\"\n[virtuose]\nrelay_time = -1\n", ":8: "},
  };
  for (const auto& [text, expected] : cases) {
    const std::string file = write(head + text);
    const std::string fault = fault_of([&] { read_device_profile(file); });
    EXPECT_NE(fault.find(expected), std::string::npos) << fault;
    EXPECT_EQ(fault.find(file), 0u) << fault;
  }
}

TEST_F(Profiles, DocumentsEveryKeyAndNoOther) {
  for (const auto& [readme, toml] :
       {std::pair{"devices/README.md", "devices/simulated.toml"}, {"devices/README.md", "devices/virtuose_6d.toml"}}) {
    const std::string config = PALP_SOURCE_DIR "/config/", text = text_of(config + readme);
    std::istringstream example(text_of(config + toml));
    std::string section;
    for (std::string line; std::getline(example, line);) {
      if (line.starts_with('[')) section = line.substr(1, line.find(']') - 1) + ".";
      const auto equals = line.find(" = ");
      if (line.starts_with('#') || equals == std::string::npos) continue;
      EXPECT_NE(text.find("`" + section + line.substr(0, equals) + "`"), std::string::npos) << section << line;
    }
  }
}

TEST_F(Profiles, RefusesWhatIsWrongAllAtOnceWithFileAndLine) {
  const std::string file = write(
      "name = \"x\"\n[limits]\nforce = 0\ntorque = \"much\"\n[arm]\nmass = -1\nmas = 2\n[coupling]\nstiffness = nan\n");
  const std::string fault = fault_of([&] { read_device_profile(file); });
  for (const char* line : {":3: ", ":4: ", ":6: ", ":7: ", ":9: "})
    EXPECT_NE(fault.find(file + line), std::string::npos) << fault;
}

}  // namespace
}  // namespace palp::test::profile_test
