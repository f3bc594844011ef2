// The one reader of pose paths.
#include "config/pose_path.h"

#include <gtest/gtest.h>

#include "config/error.h"
#include "tests/support/files.h"

namespace palp::test::pose_path_test {
namespace {

class PosePath : public ::testing::Test {
 protected:
  std::vector<PathPose> read(const std::string& text) {
    write_text(file_, text);
    return read_pose_path(file_);
  }
  std::string fault(const std::string& text) {
    try {
      read(text);
    } catch (const ConfigError& error) {
      return std::string(error.what()).substr(file_.size());
    }
    return "";
  }
  const std::string head_ = "time,x,y,z,qx,qy,qz,qw\n";
  const ScratchFolder folder_;
  const std::string file_ = folder_ / "path.csv";
};

TEST_F(PosePath, TakesCommentsBlanksAndLineEndsOfDos) {
  const std::vector<PathPose> path =
      read("# made by hand\n" + head_ + "0,1,2,3,0,0,0,1\r\n\n# half a turn\n 0.5 , 1,2,3,0,0,1.0005,0\n");
  ASSERT_EQ(path.size(), 2u);
  EXPECT_EQ(path[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(path[1].time, 0.5);
  EXPECT_DOUBLE_EQ(path[1].orientation.z(), 1);
  EXPECT_EQ(path[0].line, 3u);
  EXPECT_EQ(path[1].line, 6u);
}

TEST_F(PosePath, FaultsAreNamedWithTheirLine) {
  EXPECT_EQ(fault("t,x\n"), ":1: the header is 't,x', expected time,x,y,z,qx,qy,qz,qw");
  EXPECT_EQ(fault(head_), ": no poses, expected a header time,x,y,z,qx,qy,qz,qw and rows of numbers");
  EXPECT_EQ(fault(head_ + "0,0,0,0,0,0,0\n"), ":2: expected 8 cells: time,x,y,z,qx,qy,qz,qw");
  EXPECT_EQ(fault(head_ + "0,0,0,0,0,0,0,1,1\n"), ":2: expected 8 cells: time,x,y,z,qx,qy,qz,qw");
  EXPECT_EQ(fault(head_ + "0,0,inf,0,0,0,0,1\n"), ":2: 'inf' is no number from -1e9 to 1e9");
  EXPECT_EQ(fault(head_ + "0,0,0,0,0,0,0,2\n"), ":2: the quaternion has length 2, expected 1");
  EXPECT_EQ(fault(head_ + "1,0,0,0,0,0,0,1\n1,0,0,0,0,0,0,1\n"),
            ":3: time is 1, expected more than that of the row before");
}

}  // namespace
}  // namespace palp::test::pose_path_test
