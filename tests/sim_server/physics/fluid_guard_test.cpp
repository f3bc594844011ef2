// The guard that keeps fluids out of solids: against its equation in double precision, and in a stirred tray.
#include "sim_server/physics/fluid_guard.h"

#include <vector>

#include <gtest/gtest.h>

#include "sim_server/probes/penetration.h"
#include "sim_server/solver/constants.h"
#include "sim_server/solver/contact_store.h"
#include "sim_server/solver/particle_store.h"
#include "tests/support/played_scene.h"
#include "tests/support/random.h"
#include "tests/support/scene_builder.h"
#include "tests/support/tolerance.h"

namespace palp::test::fluid_guard_test {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing = 0.05, kRadius = 0.2;

class FluidGuard : public RandomCase {
 protected:
  FluidGuard() {
    SceneConfig config = scene(kSpacing);
    config.numerics.sound_speed = 15;
    config.gravity.setZero();
    config.bodies = {body("ball", BodyKind::rigid, sphere(kRadius)),
                     body("drop", BodyKind::fluid, box({0.2, 0.2, 0.2}, {0.7, 0, 0}))};
    scene_ = sample_scene(config, 100000);
    plan_ = make_plan(scene_);
    contact_.emplace(scene_, plan_);
    store_.emplace(scene_, plan_);
    BodyState& ball = store_->bodies[0];
    ball.x = vector(0.1).cast<real>();
    ball.q = Quat(random_rotation(random_).cast<real>());
    ball.v = vector(1).cast<real>();
    ball.w = vector(3).cast<real>();
  }

  // Puts each fluid particle somewhere near the surface and returns the guard's accelerations.
  std::vector<Vector3d> push(real share) {
    for (std::uint32_t i = first(); i < count(); ++i) {
      const Vector3d n = vector(1).normalized();
      place_.push_back(store_->bodies[0].x.cast<double>() + (kRadius + between(-0.5, 0.5) * kSpacing) * n);
      speed_.push_back(vector(0.5));
      store_->xV[i] = pack(place_.back().cast<real>(), store_->xV[i].w);
      store_->vp[i] = pack(speed_.back().cast<real>(), 0);
    }
    std::vector<Packed> acceleration(count(), Packed{0, 0, 0, share});
    const std::uint32_t of_guard = 0, place[] = {0, kNone};
    GuardFluid kernel{};
    kernel.state.xV = store_->xV.data();
    kernel.state.vp = store_->vp.data();
    kernel.state.mass = store_->mass.data();
    kernel.state.tag = store_->tag.data();
    kernel.bodies.body = store_->bodies.data();
    std::vector<GuardWrench> wrenches((count() + kGuardPart - 1) / kGuardPart);
    kernel.guard.by = {static_cast<std::uint32_t>(wrenches.size()), 1, place, wrenches.data()};
    kernel.guard.body = &of_guard;
    kernel.guard.shape = contact_->shape.data();
    kernel.guard.piece = contact_->piece.data();
    kernel.grid = make_grid(scene_, plan_);
    kernel.medium = make_medium(scene_, plan_);
    kernel.count = count();
    kernel.acceleration = acceleration.data();
    dt_ = kernel.medium.dt;
    for (std::uint32_t part = 0; part < wrenches.size(); ++part) {
      kernel(part, SerialTeam{});
      wrench_.force += wrenches[part].force;
      wrench_.torque += wrenches[part].torque;
    }
    std::vector<Vector3d> out;
    for (std::uint32_t i = first(); i < count(); ++i) out.push_back(acceleration[i].xyz().cast<double>());
    return out;
  }

  std::uint32_t first() const { return scene_.bodies[1].first; }
  std::uint32_t count() const { return first() + 64; }
  double mass(std::size_t k) const { return store_->mass[first() + k]; }

  Scene scene_;
  Plan plan_;
  std::optional<ContactStore> contact_;
  std::optional<ParticleStore> store_;
  std::vector<Vector3d> place_, speed_;
  GuardWrench wrench_{Vec3(0, 0, 0), Vec3(0, 0, 0)};
  double dt_ = 0;
};

TEST_F(FluidGuard, IsASpringAndADamperAtTheEndOfTheStep) {
  ASSERT_TRUE(plan_.guards);
  ASSERT_TRUE(store_->tag[0].guarded());
  const BodyState& ball = store_->bodies[0];
  const double reach = 0.3 * kSpacing, k = 0.05 * 15 * 15 / (reach * kSpacing);
  const std::vector<Vector3d> found = push(real(0.7));
  Vector3d force(0, 0, 0), torque(0, 0, 0);
  int pushed = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Vector3d r = place_[i] - ball.x.cast<double>(), n = r.normalized();
    const double deep = reach - (r.norm() - kRadius), b = 8 * std::sqrt(k) * deep / reach;
    const double part = (speed_[i] - ball.v.cast<double>() - ball.w.cast<double>().cross(r)).dot(n);
    const double a = deep > 0 ? std::max(0.0, (k * deep - (b + k * dt_) * part) / (1 + b * dt_ + k * dt_ * dt_)) : 0;
    EXPECT_TRUE(within((found[i] - 0.7 * a * n).norm() / (k * reach), tol::kGuard)) << i;
    pushed += a > 0;
    force -= mass(i) * found[i];
    torque -= mass(i) * r.cross(found[i]);
  }
  EXPECT_GT(pushed, 20);
  EXPECT_TRUE(within((wrench_.force.cast<double>() - force).norm() / force.norm(), tol::kGuard));
  EXPECT_TRUE(within((wrench_.torque.cast<double>() - torque).norm() / (kRadius * force.norm()), tol::kGuard));
}

TEST_F(FluidGuard, LeavesAloneWhatOtherForcesHold) {
  for (const Vector3d& a : push(0)) EXPECT_EQ(a.norm(), 0);
  EXPECT_EQ(wrench_.force.norm(), 0);
}

// Pressure and viscosity are all that a particle of a guarded solid adds: neither springs nor artificial viscosity,
// which would be a drag along the surface.
TEST_F(FluidGuard, TakesThePlaceOfSpringsAndArtificialViscosity) {
  Medium medium = make_medium(scene_, plan_);
  medium.artificial = real(0.1);
  const double H = plan_.support, mu = medium.material[store_->tag[first()].material()].viscosity;
  const WendlandC2 kernel = WendlandC2::with_support(medium.support);
  for (int k = 0; k < 20; ++k) {
    const Vector3d x_ij = between(0.3, 0.9) * kSpacing * vector(1).normalized(), v_i = vector(1), v_w = vector(1);
    const double p_i = between(0, 100), p_w = between(0, 100), V = std::pow(kSpacing, 3), r = x_ij.norm();
    const Vec3 found =
        wall_pair_force(medium, kernel, store_->tag[first()], pack(Vec3(0, 0, 0), real(V)),
                        pack(v_i.cast<real>(), real(p_i)), store_->tag[0], real(V), vector(1).cast<real>(),
                        pack(v_w.cast<real>(), real(p_w)), x_ij.cast<real>(), real(r * r));
    const double F = 20 * 21 / (2 * EIGEN_PI * std::pow(H, 5)) * std::pow(1 - r / H, 3);
    const Vector3d expected = V * V * F * ((p_i + p_w) * x_ij - 2 * mu * (v_i - v_w));
    EXPECT_TRUE(within((found.cast<double>() - expected).norm() / expected.norm(), tol::kGuard)) << k;
  }
}

// At the spacing of level fast, where the ladle is two and a half spacings wide.
TEST(FluidGuardOfATray, NoFluidEntersTheLadle) {
  PlayedScene played("tray_fluid", {"stir"});
  const PenetrationMeter meter(played.scene);
  for (int k = 1; k <= 20; ++k) {
    ASSERT_TRUE(played.play(0.1 * k));
    EXPECT_TRUE(within(meter.deepest(played.snapshot, played.simulation->output()).value() / played.scene.spacing,
                       tol::kPenetration));
  }
}

}  // namespace
}  // namespace palp::test::fluid_guard_test
