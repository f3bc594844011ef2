// Flow in a square box whose lid moves, Re = 100, against Ghia, Ghia & Shin 1982. In units of the box and the lid.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/lid.h"
#include "tests/support/tolerance.h"

namespace palp::test::lid_cavity_test {
namespace {

constexpr double kSpacing = 1.0 / 40;

// The equations, and whether solids act by their geometry or by their particles, as those of method "paper" do.
struct Form {
  Method method;
  bool by_geometry;
};
std::vector<Form> forms() {
  std::vector<Form> out{{Method::accurate, true}};
  for (const Method method : methods()) out.push_back({method, false});
  return out;
}
void PrintTo(const Form& form, std::ostream* out) {
  *out << to_string(form.method) << (form.by_geometry ? "_by_geometry" : "");
}

Scene cavity(const Form& form) {
  Scene scene = box_with_lid({.spacing = kSpacing, .by_geometry = form.by_geometry});
  scene.config.method = form.method;
  return scene;
}

// Mean of a velocity component over the fluid within a spacing and a half of a line across the box.
double mean_near(const Scene& scene, const Snapshot& s, double x, double z, std::size_t axis) {
  double sum = 0, weights = 0;
  for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i) {
    const double r = std::hypot(s.position[3 * i] - x, s.position[3 * i + 2] - z) / (1.5 * kSpacing);
    if (r >= 1) continue;
    const double weight = std::pow(1 - r, 4) * (4 * r + 1);
    sum += weight * s.velocity[3 * i + axis];
    weights += weight;
  }
  return sum / weights;
}

class LidCavity : public ::testing::TestWithParam<Form> {};

TEST_P(LidCavity, HasTheVortexOfGhia) {
  const Scene scene = cavity(GetParam());
  const auto simulation = simulate(scene);
  Snapshot s;
  // lowest u on the vertical middle line, and the two extremes of w on the horizontal one
  struct Point {
    const char* what;
    double x, z;
    std::size_t axis;
    double expected, found = 0;
  } points[] = {{"back flow under the vortex", 0.5, 0.4531, 0, -0.21090},
                {"upward flow at the left", 0.2344, 0.5, 2, 0.17527},
                {"downward flow at the right", 0.8047, 0.5, 2, -0.24533}};
  constexpr int settle = 1100, every = 10, samples = 10;
  for (int k = 0; k < settle + every * samples; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    if (k < settle || k % every != 0) continue;
    simulation->snapshot(s);
    for (Point& p : points) p.found += mean_near(scene, s, p.x, p.z, p.axis) / samples;
  }
  for (const Point& p : points)
    EXPECT_TRUE(
        within(p.found / p.expected - 1, tol::kLidCavity,
               {"D6 box with a moving lid, Re 100, 40 x 40" +
                    std::string(GetParam().by_geometry ? ", walls by geometry: " : ": ") + p.what,
                quantity(p.expected, "of the lid's speed (Ghia 1982)"), quantity(p.found, ""), GetParam().method,
                "Eq. 3 as it stands: wall particles take part with the wall's own velocity, which does not "
                "place its surface"}));
}

INSTANTIATE_TEST_SUITE_P(Forms, LidCavity, ::testing::ValuesIn(forms()), ::testing::PrintToStringParamName());

}  // namespace
}  // namespace palp::test::lid_cavity_test
