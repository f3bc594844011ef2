// Scripts of hands that are wrong: each is refused with the line of its fault.
#include "haptic_bridge/device/hand_script.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/haptic_bridge/device/device_files.h"

namespace palp::test::hand_script_test {
namespace {

using Profiles = DeviceFiles;

TEST_F(Profiles, RefusesWhatIsNoHandScript) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"grip = \"firm\"\n", "keyframe"},
      {"grip = \"strong\"\n[[keyframe]]\ntime = 0\n", ":1: "},
      {"[[keyframe]]\nposition = [0, 0, 0]\n", "time is missing"},
      {"[[keyframe]]\ntime = 1\n[[keyframe]]\ntime = 1\n", ":4: "},
      {"[[keyframe]]\ntime = 0\nrotation_deg = [0, 0]\n", ":3: "},
      {"[[keyframe]]\ntime = 0\nrotation_deg = [170, 170, 0]\n", ":3: "},
      {"[[keyframe]]\ntime = 0\n[[keyframe]]\ntime = 1\nrotation_deg = [150, 0, 0]\n", ":5: "},
      {"loop = true\n[[keyframe]]\ntime = 0\n[[keyframe]]\ntime = 1\nposition = [1, 0, 0]\n", "must end in the pose"},
      {"[grip]\nmass = -1\n[[keyframe]]\ntime = 0\n", ":2: "},
      {"[tremor]\nforce = 50\n[[keyframe]]\ntime = 0\n", ":2: "},
  };
  for (const auto& [text, expected] : cases) {
    const std::string file = write(text);
    const std::string fault = fault_of([&] { read_hand_script(file); });
    EXPECT_NE(fault.find(expected), std::string::npos) << fault << "\nof\n" << text;
  }
}

}  // namespace
}  // namespace palp::test::hand_script_test
