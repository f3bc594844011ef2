// How deep particles lie in solids, against places whose depth is known.
#include "sim_server/probes/penetration.h"

#include <gtest/gtest.h>

#include "tests/support/scene_builder.h"

namespace palp::test::penetration_test {
namespace {

using Eigen::Vector3d;

// A pool of which any particle can be put anywhere, a floor, and a slab that is a tool.
class Penetration : public ::testing::Test {
 protected:
  Penetration() {
    SceneConfig config = scene(0.1);
    config.bodies = {body("pool", BodyKind::fluid, box({0.4, 0.4, 0.4}, {0, 0, 0.3})),
                     body("floor", BodyKind::fixed, box({1, 1, 0.4}, {0, 0, -0.2})),
                     body("slab", BodyKind::rigid, box({0.6, 0.2, 0.2}, {0, 0, 0.8}))};
    scene_ = sample_scene(config, 100000);
    for (const Vector3d& x : scene_.position)
      for (int a = 0; a < 3; ++a) snapshot_.position.push_back(static_cast<float>(x[a]));
    output_.bodies.resize(3);
    for (std::size_t b = 0; b < 3; ++b) {
      output_.bodies[b].state.position = scene_.bodies[b].position;
      output_.bodies[b].state.orientation = scene_.bodies[b].orientation;
    }
  }

  void put(std::size_t particle, const Vector3d& x) {
    for (std::size_t a = 0; a < 3; ++a)
      snapshot_.position[3 * particle + a] = static_cast<float>(x[static_cast<int>(a)]);
  }
  std::optional<double> deepest() const { return PenetrationMeter(scene_).deepest(snapshot_, output_); }

  Scene scene_;
  Snapshot snapshot_;
  StepOutput output_;
};

TEST_F(Penetration, IsNoneOutsideAndTheDeepestWithin) {
  EXPECT_EQ(deepest().value(), 0);
  put(3, {0.1, 0, -0.02});
  EXPECT_NEAR(deepest().value(), 0.02, 1e-6);
  put(5, {0.47, 0.1, -0.2});  // 3 cm within the floor's side
  EXPECT_NEAR(deepest().value(), 0.03, 1e-6);
}

TEST_F(Penetration, FollowsTheBody) {
  const Vector3d within(0.06, 0, 1.5);
  put(2, within);
  EXPECT_EQ(deepest().value(), 0);
  output_.bodies[2].state.position = within - scene_.bodies[2].center;
  EXPECT_NEAR(deepest().value(), 0.1, 1e-6);
  // the slab upright, and the particle 6 cm off its middle, along its thickness
  output_.bodies[2].state.orientation = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitY());
  output_.bodies[2].state.position =
      within - Vector3d(0.06, 0, 0) - output_.bodies[2].state.orientation * scene_.bodies[2].center;
  EXPECT_NEAR(deepest().value(), 0.04, 1e-6);
}

TEST_F(Penetration, PassesOverWhatIsNoMatterInItsPlace) {
  put(0, {0, 0, -0.1});
  snapshot_.inactive.assign(scene_.position.size(), 0);
  snapshot_.inactive[0] = 1;
  put(1, Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(deepest().value(), 0);
  for (Body& b : scene_.bodies) b.contact = nullptr;
  EXPECT_FALSE(deepest().has_value());
}

}  // namespace
}  // namespace palp::test::penetration_test
