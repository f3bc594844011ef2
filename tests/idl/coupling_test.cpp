// The coupling law against a restatement from energies, and the local model against the law itself.
#include "idl/coupling.h"

#include <random>

#include <gtest/gtest.h>

#include "haptic_bridge/loop/local_model.h"
#include "tests/support/seed.h"

namespace palp::test::coupling_test {
namespace {

using Vec3 = Eigen::Vector3d;
using Quat = Eigen::Quaterniond;
using Handle = RigidState;

constexpr double kFiniteDifference = 1e-6;  // error of a central difference in double, relative to the gains used here
constexpr Gains<double> kGains{800, 15, 7, 0.3};

struct Draw {
  explicit Draw(std::uint64_t seed) : random(seed) {}
  Vec3 vector(double scale) {
    std::normal_distribution<double> n(0, scale);
    return {n(random), n(random), n(random)};
  }
  Quat rotation(double angle) { return Quat(Eigen::AngleAxisd(angle, vector(1).normalized())); }
  Quat anywhere() {
    std::normal_distribution<double> n;
    return Quat(n(random), n(random), n(random), n(random)).normalized();
  }
  Handle handle() { return {vector(0.1), anywhere(), vector(0.3), vector(2)}; }
  std::mt19937_64 random;
};

// The angle between two orientations without any of the code under test: from the trace of the rotation matrix.
double angle_between(const Quat& a, const Quat& b) {
  const Eigen::Matrix3d r = b.toRotationMatrix() * a.toRotationMatrix().transpose();
  return std::acos(std::clamp((r.trace() - 1) / 2, -1.0, 1.0));
}

double energy(const Handle& device, const Handle& proxy) {
  const double angle = angle_between(device.orientation, proxy.orientation);
  return 0.5 * kGains.stiffness * (proxy.position - device.position).squaredNorm() +
         0.5 * kGains.angular_stiffness * angle * angle;
}

TEST(Coupling, WrenchIsMinusTheDerivativeOfTheStoredEnergy) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Draw draw(seed);
  std::uniform_real_distribution<double> angles(0.05, kMaxCouplingAngle - 0.05);
  for (int i = 0; i < 200; ++i) {
    Handle proxy = draw.handle(), device = draw.handle();
    device.orientation = draw.rotation(angles(draw.random)) * proxy.orientation;
    device.linear = proxy.linear;
    device.angular = proxy.angular;
    const Wrench<double> wrench = coupling_wrench(kGains, device, proxy);
    const double h = 1e-5;
    for (int axis = 0; axis < 3; ++axis) {
      Handle ahead = device, behind = device;
      ahead.position[axis] += h;
      behind.position[axis] -= h;
      const double force = -(energy(ahead, proxy) - energy(behind, proxy)) / (2 * h);
      ASSERT_NEAR(wrench.force[axis], force, kFiniteDifference * 1e3);
      ahead = behind = device;
      ahead.orientation = Quat(Eigen::AngleAxisd(h, Vec3::Unit(axis))) * device.orientation;
      behind.orientation = Quat(Eigen::AngleAxisd(-h, Vec3::Unit(axis))) * device.orientation;
      const double torque = -(energy(ahead, proxy) - energy(behind, proxy)) / (2 * h);
      ASSERT_NEAR(wrench.torque[axis], torque, kFiniteDifference * 1e3);
    }
  }
}

TEST(Coupling, DampersTakeEnergyFromRelativeMotionOnly) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Draw draw(seed);
  for (int i = 0; i < 1000; ++i) {
    Handle proxy = draw.handle(), device = draw.handle();
    device.position = proxy.position;
    device.orientation = proxy.orientation;
    const Wrench<double> w = coupling_wrench(kGains, device, proxy);
    EXPECT_LE(w.force.dot(device.linear - proxy.linear) + w.torque.dot(device.angular - proxy.angular), 0);
    device.linear = proxy.linear;
    device.angular = proxy.angular;
    const Wrench<double> none = coupling_wrench(kGains, device, proxy);
    EXPECT_EQ(none.force.norm(), 0);
    EXPECT_LT(none.torque.norm(), 1e-12);
  }
}

TEST(Coupling, ProxyGetsTheOppositeWrench) {
  Draw draw(11);
  for (int i = 0; i < 1000; ++i) {
    const Handle a = draw.handle(), b = draw.handle();
    const Wrench<double> ab = coupling_wrench(kGains, a, b), ba = coupling_wrench(kGains, b, a);
    ASSERT_LT((ab.force + ba.force).norm(), 1e-9);
    ASSERT_LT((ab.torque + ba.torque).norm(), 1e-9);
  }
}

TEST(Coupling, BothQuaternionsOfAnOrientationGiveTheSameTorque) {
  Draw draw(12);
  for (int i = 0; i < 1000; ++i) {
    Handle a = draw.handle(), b = draw.handle();
    const Wrench<double> one = coupling_wrench(kGains, a, b);
    a.orientation.coeffs() = -a.orientation.coeffs();
    const Wrench<double> two = coupling_wrench(kGains, a, b);
    ASSERT_LT((one.torque - two.torque).norm(), 1e-9);
  }
}

TEST(Coupling, TurnsTheShorterWayAndIsHeldPastItsLargestAngle) {
  const Quat id = Quat::Identity();
  const auto about_z = [](double angle) { return Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ())); };
  EXPECT_NEAR(rotation_between(id, about_z(1.5)).z(), 1.5, 1e-12);
  EXPECT_NEAR(rotation_between(id, about_z(2 * M_PI - 1.5)).z(), -1.5, 1e-12);
  EXPECT_NEAR(rotation_between(id, about_z(2.9)).z(), kMaxCouplingAngle, 1e-12);
  EXPECT_NEAR(rotation_between(id, about_z(-3.1)).z(), -kMaxCouplingAngle, 1e-12);
  EXPECT_NEAR(rotation_between(id, about_z(1e-8)).z(), 1e-8, 1e-16);
}

TEST(Coupling, IsTheSameInEveryFrame) {
  Draw draw(13);
  for (int i = 0; i < 200; ++i) {
    const Handle a = draw.handle(), b = draw.handle();
    const Quat r = draw.anywhere();
    const Vec3 t = draw.vector(1);
    const auto moved = [&](const Handle& h) {
      return Handle{r * h.position + t, r * h.orientation, r * h.linear, r * h.angular};
    };
    const Wrench<double> w = coupling_wrench(kGains, a, b), turned = coupling_wrench(kGains, moved(a), moved(b));
    ASSERT_LT((r * w.force - turned.force).norm(), 1e-9);
    ASSERT_LT((r * w.torque - turned.torque).norm(), 1e-9);
  }
}

ProxySample sample_of(const Handle& device, const Handle& proxy, double blend) {
  ProxySample s;
  const Wrench<double> w = coupling_wrench(kGains, device, proxy);
  s.device_pose = to_pose(device);
  s.device_twist = to_twist(device);
  s.proxy_pose = to_pose(proxy);
  s.wrench = {{w.force.x(), w.force.y(), w.force.z()}, {w.torque.x(), w.torque.y(), w.torque.z()}};
  s.gains = {kGains.stiffness, kGains.damping, kGains.angular_stiffness, kGains.angular_damping};
  s.blend = {blend, blend};
  return s;
}

TEST(LocalModel, WithFullBlendIsTheSpringToTheProxyHeldStill) {
  Draw draw(14);
  for (int i = 0; i < 200; ++i) {
    Handle proxy = draw.handle(), then = proxy, now = proxy;
    then.position += draw.vector(0.01);
    now.position = then.position + draw.vector(0.01);
    now.linear = draw.vector(0.3);
    now.angular = draw.vector(2);
    // rotations about one axis, where the first order is exact
    then.orientation = Quat(Eigen::AngleAxisd(0.3, Vec3::UnitY())) * proxy.orientation;
    now.orientation = Quat(Eigen::AngleAxisd(0.4, Vec3::UnitY())) * proxy.orientation;
    const Wrench<double> law = coupling_wrench(kGains, now, proxy);
    const Wrench<double> model = evaluate(local_model(sample_of(then, proxy, 1)), now);
    ASSERT_LT((law.force - model.force).norm(), 1e-9);
    ASSERT_LT((law.torque - model.torque).norm(), 1e-9);
  }
}

TEST(LocalModel, WithoutBlendIsTheWrenchHeld) {
  Draw draw(15);
  const Handle proxy = draw.handle(), then = draw.handle(), now = draw.handle();
  const Wrench<double> sent = coupling_wrench(kGains, then, proxy);
  const Wrench<double> model = evaluate(local_model(sample_of(then, proxy, 0)), now);
  EXPECT_EQ(model.force, sent.force);
  EXPECT_EQ(model.torque, sent.torque);
}

TEST(LocalModel, GoesOverToANewSampleWithoutAStep) {
  Draw draw(16);
  const Handle proxy = draw.handle(), device = draw.handle();
  Handle other = proxy;
  other.position += Vec3(0.01, 0, 0);
  const double decay = std::exp(-1.0 / 5);
  BlendedModel model(decay);
  model.reset(local_model(sample_of(device, proxy, 1)));
  const Wrench<double> before = model.at(device);
  model.change(local_model(sample_of(device, other, 1)), device);
  EXPECT_LT((model.at(device).force - before.force).norm(), 1e-9);
  for (int i = 0; i < 5; ++i) model.decay();
  const Vec3 target = coupling_wrench(kGains, device, other).force;
  EXPECT_NEAR((model.at(device).force - target).norm() / (before.force - target).norm(), std::exp(-1), 1e-9);
  // the residual does not touch the local term: the stiffness is felt at once
  Handle moved = device;
  moved.position += Vec3(0, 0, 0.001);
  EXPECT_NEAR((model.at(moved).force - model.at(device).force).z(), -kGains.stiffness * 0.001, 1e-9);
}

}  // namespace
}  // namespace palp::test::coupling_test
