// Paths through keyframes: smooth, through each of them, and refused where they are none.
#include "haptic_bridge/device/trajectory.h"

#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/haptic_bridge/device/poses.h"

namespace palp::test::trajectory_test {
namespace {

using Quat = Eigen::Quaterniond;

std::vector<Keyframe> some_path() {
  return {{0, {0, 0, 0}, Quat::Identity()},
          {0.5, {0.1, 0, 0.05}, turn(1.0, {1, 2, 0})},
          {0.8, {0.1, 0.2, 0}, turn(-0.7, {0, 1, 1})},
          {2.0, {0, 0.1, -0.1}, turn(1.2, {1, 0, 3})},
          {2.5, {0, 0, 0}, Quat::Identity()}};
}

TEST(Trajectory, TwistIsTheDerivativeOfThePose) {
  const double h = 1e-6, kTolerance = 1e-4;  // central difference of a cubic near unit speed
  for (const Interpolation kind : {Interpolation::catmull_rom, Interpolation::minimum_jerk}) {
    const Trajectory path(some_path(), kind, true);
    for (double t = 0.013; t < 6; t += 0.0371) {
      const RigidState now = path.at(t), ahead = path.at(t + h), behind = path.at(t - h);
      EXPECT_LT((now.linear - (ahead.position - behind.position) / (2 * h)).norm(), kTolerance) << t;
      EXPECT_LT((now.angular - rotation_between(behind.orientation, ahead.orientation) / (2 * h)).norm(), kTolerance)
          << t;
      EXPECT_NEAR(now.orientation.norm(), 1, 1e-12);
    }
  }
}

TEST(Trajectory, PassesThroughItsKeyframesWithoutAJumpInTwist) {
  const Trajectory path(some_path(), Interpolation::catmull_rom, true);
  const double h = 1e-9;
  for (const Keyframe& k : path.keyframes()) {
    const RigidState before = path.at(2.5 + k.time - h), after = path.at(2.5 + k.time + h);
    EXPECT_LT((before.position - k.x).norm(), 1e-8);
    EXPECT_LT(rotation_between(before.orientation, k.q).norm(), 1e-7);
    EXPECT_LT((before.linear - after.linear).norm(), 1e-6);
    EXPECT_LT((before.angular - after.angular).norm(), 1e-5);
  }
}

TEST(Trajectory, RestsBeforeItsBeginAndAfterItsEnd) {
  std::vector<Keyframe> keys = some_path();
  keys.back().x.x() = 0.5;
  const Trajectory path(keys, Interpolation::minimum_jerk, false);
  EXPECT_EQ(path.at(-1).position, keys.front().x);
  EXPECT_EQ(path.at(100).position, keys.back().x);
  EXPECT_EQ(path.at(100).linear.norm(), 0);
}

TEST(Trajectory, RefusesWhatIsNoPath) {
  const auto refused = [](std::vector<Keyframe> k, bool loop) {
    EXPECT_THROW(Trajectory(std::move(k), Interpolation::catmull_rom, loop), std::invalid_argument);
  };
  refused({}, false);
  refused({{0, {0, 0, 0}}, {0, {1, 0, 0}}}, false);
  refused({{0, {0, 0, 0}}, {1, {1, 0, 0}}}, true);
  refused({{0, {0, 0, 0}}, {1, {0, 0, 0}, turn(3, {0, 0, 1})}}, false);
  refused({{0, {0, 0, 0}}}, true);
}

}  // namespace
}  // namespace palp::test::trajectory_test
