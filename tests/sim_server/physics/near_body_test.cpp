// How pressure goes on into a solid along which fluid flows, and how thick a layer it drags along, against the
// curvature of the solid's surface.
#include "sim_server/physics/near_body.h"

#include <algorithm>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "sim_server/solver/constants.h"
#include "sim_server/solver/contact_store.h"
#include "tests/support/random.h"
#include "tests/support/scene_builder.h"
#include "tests/support/tolerance.h"

namespace palp::test::near_body_test {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing = 0.05;

// One solid at the origin.
class FeltGravity : public RandomCase {
 protected:
  void stand(const std::vector<ShapeConfig>& shapes) {
    SceneConfig config = scene(kSpacing);
    config.bodies = {body("solid", BodyKind::fixed, shapes[0]),
                     body("fluid", BodyKind::fluid, box({0.1, 0.1, 0.1}, {0, 0, 0.9}))};
    config.bodies[0].shapes = shapes;
    scene_ = sample_scene(config, 1000000);
    contact_.emplace(scene_, make_plan(scene_));
    grids_ = contact_->grids_at(contact_->node.data());
    walls_.shape = contact_->shape.data();
    walls_.piece = contact_->piece.data();
    walls_.grid = grids_.data();
    center_ = scene_.bodies[0].position + scene_.bodies[0].center;
  }

  // Returns what is felt at x beside gravity by what has the velocity u against the solid.
  Vector3d beside_gravity(const Vector3d& x, const Vector3d& u) const {
    const Vec3 g(1, 2, 3);
    return (followed(x, u, g).g - g).cast<double>();
  }

  // Returns the layer in spacings, or 0 where there is none.
  double layer(const Vector3d& x, const Vector3d& u) const {
    const real found = followed(x, u, Vec3(0, 0, 0)).layer;
    return found < kNoLayer ? found / kSpacing : 0;
  }

  void expect_near(const Vector3d& found, const Vector3d& exact, double of) {
    EXPECT_TRUE(within((found - exact).norm() / of, tol::kSurfaceBend))
        << found.transpose() << ", " << exact.transpose();
  }

  static constexpr double kViscosity = 1e-4;  // over the density

 private:
  Following followed(const Vector3d& x, const Vector3d& u, const Vec3& g) const {
    const Vec3 y = (x - center_).cast<real>();
    const Distance at = solid_distance(contact_->shape[0], walls_.piece, walls_.grid, y);
    return following(walls_, contact_->shape[0], at, real(kSpacing), y, u.cast<real>(), g, real(kViscosity));
  }

  Scene scene_;
  std::optional<ContactStore> contact_;
  std::vector<NodeGrid> grids_;
  WallViews walls_;
  Vector3d center_;
};

TEST_F(FeltGravity, OfWhatComesTowardsABallIsTheSpeedSquaredOverItsRadius) {
  const double R = 5 * kSpacing;
  stand({sphere(R)});
  for (int k = 0; k < 200; ++k) {
    const Vector3d n = vector(1).normalized(), u_t = n.cross(vector(1));
    const double r = R + between(0, 2.5) * kSpacing, all = u_t.squaredNorm() / r, away = between(-0.6, 0.6);
    const double share = std::clamp(-away / 0.45, 0.0, 1.0);
    expect_near(beside_gravity(r * n, u_t + away * u_t.norm() * n), share * all * n, all);
  }
}

// A flow that also goes along the axis turns by the square of its part around it.
TEST_F(FeltGravity, InBoresAndBesideRodsIsThatOfWhatGoesAround) {
  const double R = 6 * kSpacing;
  for (const bool bore : {false, true}) {
    stand(bore ? std::vector{box({0.9, 0.9, 0.9}), cut(cylinder(R, 2))} : std::vector{cylinder(R, 1.5)});
    for (int k = 0; k < 200; ++k) {
      const double angle = between(0, 2 * M_PI), away = between(0.05, 2) * kSpacing, r = bore ? R - away : R + away;
      const Vector3d out(std::cos(angle), std::sin(angle), 0), around(-out.y(), out.x(), 0), z(0, 0, 1);
      const Vector3d x = r * out + between(-0.2, 0.2) * z, u_t = between(-1, 1) * around + between(-1, 1) * z;
      const double part = u_t.dot(around), all = u_t.squaredNorm() / r;
      const Vector3d u = u_t - (bore ? 0 : 0.5) * u_t.norm() * out;
      expect_near(beside_gravity(x, u), part * part / r * out, all);
    }
  }
}

// Laminar ones grow with the root of the viscosity over the speed and over how much the surface bends along the flow.
TEST_F(FeltGravity, LayersAreThoseOfLaminarFlowsWhereASurfaceBulges) {
  const double R = 6 * kSpacing;
  std::uint32_t thick = 0;
  for (const bool bore : {false, true}) {
    stand(bore ? std::vector{box({0.9, 0.9, 0.9}), cut(cylinder(R, 2))} : std::vector{cylinder(R, 1.5)});
    for (int k = 0; k < 200; ++k) {
      const double angle = between(0, 2 * M_PI), away = between(0.05, 2) * kSpacing, r = bore ? R - away : R + away;
      const Vector3d out(std::cos(angle), std::sin(angle), 0), around(-out.y(), out.x(), 0), z(0, 0, 1);
      const Vector3d u_t = between(0.02, 0.1) * around + between(-0.1, 0.1) * z;
      const double part = u_t.dot(around), bend = part * part / u_t.squaredNorm() / r;
      const double exact = std::max(0.25, std::sqrt(kViscosity / (bend * u_t.norm())) / 0.6 / kSpacing);
      const double found = layer(r * out, u_t + between(-0.1, 0.1) * out);
      if (bore)
        EXPECT_EQ(found, 0);
      else
        EXPECT_TRUE(within(found / exact - 1, tol::kSurfaceBend)) << found << ", " << exact;
      thick += !bore && exact > 0.25;
    }
  }
  EXPECT_GT(thick, 50u);
}

TEST_F(FeltGravity, BesideFlatFacesAndInCornersIsGravity) {
  stand({box({0.4, 0.4, 0.4})});
  for (int k = 0; k < 100; ++k) {
    const Vector3d x(0.2 + between(0, 2) * kSpacing, between(-0.3, 0.3), between(-0.3, 0.3));
    EXPECT_EQ(beside_gravity(x, vector(1)).norm(), 0);
    EXPECT_EQ(layer(x, vector(1)), 0);
  }
  stand({cylinder(0.5, 0.8), cut(cylinder(0.4, 0.8, {0, 0, 0.1}))});
  // in a pan, outwards along its floor to where its rim begins
  EXPECT_EQ(beside_gravity({0.39, 0, -0.29}, {1, 0, 0}).norm(), 0);
}

}  // namespace
}  // namespace palp::test::near_body_test
