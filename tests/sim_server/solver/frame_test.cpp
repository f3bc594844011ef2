// Frames: what they say of the particles.
#include "tests/support/backend.h"
#include "tests/support/scenes.h"

namespace palp::test::frame_test {
namespace {

// A pool whose water stands under its own weight, with a box above it.
Scene pool_and_box() {
  Scene scene = pool_of_water();
  add_body(scene, "box", BodyKind::rigid, 0, {-0.1, -0.1, 0.3}, {0.1, 0.1, 0.4});
  return scene;
}

TEST(Frame, TellsByHowMuchDensityErrs) {
  const Scene scene = pool_and_box();
  const auto simulation = simulate(scene);
  simulation->step({});
  const std::vector<float> density = frame_of(*simulation, ScalarField::density).scalar;
  const std::vector<float> error = frame_of(*simulation, ScalarField::density_error).scalar;
  ASSERT_EQ(error.size(), scene.position.size());
  ASSERT_EQ(density.size(), error.size());
  const double rest = scene.config.materials[0].density;
  float most = 0;
  for (std::size_t i = 0; i < error.size(); ++i) {
    EXPECT_NEAR(error[i], density[i] / rest - 1, 2e-7) << i;
    most = std::max(most, error[i]);
  }
  EXPECT_GT(most, 1e-5f) << "water under pressure is denser than at rest";
}

TEST(Frame, TellsWhatIsSolidWhereNothingChanges) {
  const Scene scene = pool_and_box();
  const auto simulation = simulate(scene);
  const std::vector<float> state = frame_of(*simulation, ScalarField::state).scalar;
  ASSERT_EQ(state.size(), scene.position.size());
  for (std::size_t i = 0; i < state.size(); ++i)
    EXPECT_EQ(state[i], scene.bodies[scene.body[i]].type == BodyKind::fluid ? 0.0f : 1.0f) << i;
}

}  // namespace
}  // namespace palp::test::frame_test
