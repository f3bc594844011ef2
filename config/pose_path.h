// A path of poses through time in a CSV file, as the bridge's device `replay` and palp_run read it. How the poses are
// joined is theirs: an arm that is driven needs a twist without jumps, a study the straight lines that it asked for.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace palp {

struct PathPose {
  double time = 0;                                     // [s]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // [m]
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  std::size_t line = 0;  // of the file
};

// Reads the header time,x,y,z,qx,qy,qz,qw and rows of numbers from -1e9 to 1e9 whose times increase; quaternions have
// length 1 within 1e-3 and are normalized. Empty lines and those that begin with # say nothing; blanks around a number
// and line ends of DOS are allowed. At least one pose. Throws ConfigError with file:line.
std::vector<PathPose> read_pose_path(const std::string& file);

}  // namespace palp
