// Between the arm's frame and the world's.
#include <cmath>

#include "haptic_bridge/device/virtuose/frames.h"
#include "haptic_bridge/loop/local_model.h"
#include "tests/support/random.h"

namespace palp::test::arm_frame_test {
namespace {

using Vec3 = Eigen::Vector3d;
using Quat = Eigen::Quaterniond;

constexpr double kInFloat = 1e-6;  // of metres and radians below one, as float keeps them

Quat turn(double angle, const Vec3& axis) { return Quat(Eigen::AngleAxisd(angle, axis.normalized())); }

const RigidState kOrigin = at_rest(Vec3::Zero(), Quat::Identity());
const float kHalf = static_cast<float>(std::sqrt(0.5));

TEST(ArmFrame, TheOperatorsAxesBecomeTheWorlds) {
  ArmFrame frame(default_arm_axes(), kOrigin);
  // 3 cm towards the operator, 2 cm to the right, 1 cm up, a quarter turn about the arm's X
  const RigidState h = frame.to_world({0.03F, 0.02F, 0.01F, kHalf, 0, 0, kHalf}, {3, 2, 1, 0.3F, 0.2F, 0.1F});
  EXPECT_LT((h.position - Vec3(0.02, -0.03, 0.01)).norm(), kInFloat);
  EXPECT_LT((h.linear - Vec3(2, -3, 1)).norm(), kInFloat);
  EXPECT_LT((h.angular - Vec3(0.2, -0.3, 0.1)).norm(), kInFloat);
  EXPECT_LT((rotation_between(Quat::Identity(), h.orientation) - Vec3(0, -M_PI / 2, 0)).norm(), kInFloat);
}

TEST(ArmFrame, AWrenchOfTheWorldBecomesTheOperators) {
  const ArmFrame frame(default_arm_axes(), kOrigin);
  const ArmVector w = frame.to_arm(Vec3(1, 2, 3), Vec3(0.1, 0.2, 0.3));
  const ArmVector expected{-2, 1, 3, -0.2F, 0.1F, 0.3F};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(w[i], expected[i], kInFloat) << i;
}

TEST(ArmFrame, TheToolBeginsAtTheStartWhereverTheHandleIs) {
  const RigidState start = at_rest({1, 2, 3}, turn(0.7, {1, 0, 2}));
  ArmFrame frame(default_arm_axes(), start);
  const ArmPose here{0.4F, -0.1F, 0.2F, 0, kHalf, 0, kHalf};
  frame.place(here);
  const RigidState h = frame.to_world(here, {});
  EXPECT_LT((h.position - start.position).norm(), kInFloat);
  EXPECT_LT(rotation_between(start.orientation, h.orientation).norm(), kInFloat);
  // turned by a quarter about the world's z from there, whatever the handle's own orientation
  const Quat before = ArmFrame::orientation(here), after = turn(M_PI / 2, {0, 0, 1}) * before;
  const RigidState turned =
      frame.to_world({0.4F, -0.1F, 0.2F, static_cast<float>(after.x()), static_cast<float>(after.y()),
                      static_cast<float>(after.z()), static_cast<float>(after.w())},
                     {});
  EXPECT_LT((rotation_between(start.orientation, turned.orientation) - Vec3(0, 0, M_PI / 2)).norm(), kInFloat);
}

class AnyFrame : public RandomCase {};

TEST_F(AnyFrame, BackAndForthIsTheSamePoseAndPowerIsTheSameInBothFrames) {
  for (int i = 0; i < 200; ++i) {
    const Quat axes = random_rotation(random_);
    ArmFrame frame(axes.toRotationMatrix(), at_rest(vector(1), random_rotation(random_)));
    const auto pose = [&] {
      const Vec3 x = vector(0.5);
      const Quat q = random_rotation(random_);
      return ArmPose{static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z()),
                     static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
                     static_cast<float>(q.w())};
    };
    frame.place(pose());
    const ArmPose there = pose();
    ArmVector speed;
    for (float& s : speed) s = static_cast<float>(between(-1, 1));
    const RigidState h = frame.to_world(there, speed);
    const ArmPose back = frame.to_arm(h.position, h.orientation);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(back[k], there[k], kInFloat);
    EXPECT_LT(rotation_between(ArmFrame::orientation(there), ArmFrame::orientation(back)).norm(), 1e-5);
    const Wrench<double> w{vector(10), vector(1)};
    const ArmVector f = frame.to_arm(w.force, w.torque);
    double power = 0;
    for (int k = 0; k < 6; ++k) power += static_cast<double>(f[k]) * static_cast<double>(speed[k]);
    EXPECT_NEAR(power, w.force.dot(h.linear) + w.torque.dot(h.angular), 1e-5);
  }
}

}  // namespace
}  // namespace palp::test::arm_frame_test
