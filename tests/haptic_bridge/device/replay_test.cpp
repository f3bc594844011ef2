// Recorded paths: played as they are, and refused with the line of each fault.
#include "haptic_bridge/device/replay.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "haptic_bridge/loop/local_model.h"
#include "tests/haptic_bridge/device/device_files.h"

namespace palp::test::replay_test {
namespace {

using Replay = DeviceFiles;

const std::string kHead = "time,x,y,z,qx,qy,qz,qw\n";

TEST_F(Replay, PlaysThePathAndHoldsItsEnd) {
  ReplayDevice device(write(kHead + "5,0,0,0,0,0,0,1\n6,0.1,0,0,0,0,0,1\n7,0.2,0,0,0,0,0.70710678,0.70710678\n"),
                      false);
  DeviceReading reading;
  ASSERT_TRUE(device.read(123, reading));
  EXPECT_EQ(reading.state.position.x(), 0);
  ASSERT_TRUE(device.read(123 + 1'000'000'000, reading));
  EXPECT_NEAR(reading.state.position.x(), 0.1, 1e-12);
  EXPECT_NEAR(reading.state.linear.x(), 0.1, 1e-12);
  ASSERT_TRUE(device.read(123 + 9'000'000'000, reading));
  EXPECT_NEAR(reading.state.position.x(), 0.2, 1e-12);
  EXPECT_EQ(reading.state.linear.norm(), 0);
  EXPECT_NEAR(rotation_between(Eigen::Quaterniond::Identity(), reading.state.orientation).z(), M_PI / 2, 1e-7);
}

TEST_F(Replay, NamesTheLineOfEachFault) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "no poses"},
      {"t,x,y,z\n", ":1: the header is"},
      {kHead, "no poses"},
      {kHead + "0,0,0,0,0,0,0\n", ":2: expected 8 cells"},
      {kHead + "0,0,0,0,0,0,0,1,9\n", ":2: expected 8 cells"},
      {kHead + "0,0,0,0,0,0,0,1\n1,a,0,0,0,0,0,1\n", ":3: 'a' is no number"},
      {kHead + "0,0,0,nan,0,0,0,1\n", ":2: 'nan' is no number"},
      {kHead + "0,0,0,0,0,0,0,0.9\n", ":2: the quaternion"},
      {kHead + "0,0,0,0,0,0,0,1\n0,0,0,0,0,0,0,1\n", ":3: time is 0, expected more"},
      {kHead + "0,0,0,0,0,0,0,1\n1,0,0,0,1,0,0,0\n", ":3: it turns by more than 143 degrees"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string file = write(text);
    const std::string fault = fault_of([&] { ReplayDevice device(file, false); });
    EXPECT_NE(fault.find(expected), std::string::npos) << fault;
    EXPECT_EQ(fault.find(file), 0u) << fault;
  }
  EXPECT_NE(fault_of([] { ReplayDevice d("/nowhere/path.csv", false); }).find("no such file"), std::string::npos);
  const std::string open_path = write(kHead + "0,0,0,0,0,0,0,1\n1,1,0,0,0,0,0,1\n");
  EXPECT_NE(fault_of([&] { ReplayDevice d(open_path, true); }).find("must end in the pose"), std::string::npos);
}

}  // namespace
}  // namespace palp::test::replay_test
