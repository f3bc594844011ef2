// Conduction, melting and cooling against exact solutions (physics reference C and D17). Units of the problem: density
// and heat capacity are 1, so the diffusivity is the conductivity.
#include <functional>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::heat_flow_test {
namespace {

constexpr double kSpacing = 0.05, kDeep = 9 * kSpacing;

// A bar along x, periodic across.
Scene bar(double low, double high) {
  Scene scene = empty_scene(kSpacing, {low, 0, 0}, {high, kDeep, kDeep});
  scene.config.periodic = {false, true, true};
  scene.config.gravity.setZero();
  scene.config.rate_hz = 400;
  scene.config.numerics.support_over_spacing = 3;
  scene.config.numerics.max_speed = 0.1;
  return scene;
}

std::uint32_t add_conductor(Scene& scene, double k) {
  const auto material = add_material(scene, 1, 0.1);
  scene.config.materials[material].conductivity = k;
  scene.config.materials[material].heat_capacity = 1;
  return material;
}

// A piece of the bar, at one temperature.
Body& add_piece(Scene& scene, const std::string& name, std::uint32_t material, double low, double high, double T,
                BodyKind type = BodyKind::fixed) {
  add_body(scene, name, type, material, {low, 0, 0}, {high, kDeep, kDeep});
  scene.temperature.resize(scene.position.size(), T);
  return scene.bodies.back();
}

double x_of(const Snapshot& s, std::size_t i) { return s.position[3 * i]; }

using Profile = std::function<double(double x, double t)>;

// Largest difference of a particle's temperature from the exact one at each of the times, over the driving difference.
void expect_profile(const Scene& scene, const std::vector<double>& times, double driving, const std::string& title,
                    const Profile& exact, Snapshot* last = nullptr) {
  const auto simulation = simulate(scene);
  Snapshot s;
  for (const double t : times) {
    while (simulation->output().time < t - 1e-9) {
      const StepOutput& out = simulation->step({});
      ASSERT_TRUE(out.health.ok) << out.health.cause;
    }
    simulation->snapshot(s);
    double worst = 0;
    for (std::size_t i = 0; i < scene.position.size(); ++i)
      if (!scene.bodies[scene.body[i]].holds_temperature)
        worst = std::max(worst, std::abs(s.temperature[i] - exact(x_of(s, i), simulation->output().time)));
    EXPECT_TRUE(within(worst / driving, tol::kHeatProfile,
                       {title, "erfc profile, worst place and time",
                        quantity(worst, "K off, of ") + quantity(driving, "K"), scene.config.method}))
        << "t = " << t;
    ::testing::Test::RecordProperty("error_at_" + std::to_string(t), std::to_string(worst / driving));
  }
  if (last != nullptr) *last = s;
}

TEST(HeatFlow, ASemiInfiniteBodyWarmsFromItsEnd) {
  Scene scene = bar(-3 * kSpacing, 2);
  const auto stuff = add_conductor(scene, 1);
  add_piece(scene, "wall", stuff, -3 * kSpacing, 0, 1).holds_temperature = true;
  add_piece(scene, "body", stuff, 0, 2, 0);
  expect_profile(scene, {0.05, 0.1}, 1, "D17 semi-infinite body warmed from its end",
                 [](double x, double t) { return std::erfc(x / (2 * std::sqrt(t))); });
}

// Two half-spaces that touch at x = 0: there it soon is (e1 T1 + e2 T2) / (e1 + e2), e = sqrt(k rho c).
void expect_half_spaces(double k, BodyKind right, double between, const std::string& title) {
  const double until = 0.02, left_end = -4 * std::sqrt(until), right_end = 4 * std::sqrt(k * until);
  Scene scene = bar(left_end, right_end);
  add_piece(scene, "left", add_conductor(scene, 1), left_end, 0, 0);
  add_piece(scene, "right", add_conductor(scene, k), 0, right_end, 1, right);
  Snapshot s;
  expect_profile(
      scene, {until / 2, until}, 1, title + ": profile",
      [=](double x, double t) {
        return x < 0 ? between * std::erfc(-x / (2 * std::sqrt(t)))
                     : 1 - (1 - between) * std::erfc(x / (2 * std::sqrt(k * t)));
      },
      &s);
  double sum[2] = {0, 0}, count = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (std::abs(x_of(s, i)) < kSpacing) {
      sum[x_of(s, i) > 0 ? 1 : 0] += s.temperature[i];
      ++count;
    }
  // what the two innermost layers conduct to their common face
  const double T = 2 * (sum[0] + k * sum[1]) / (1 + k) / count;
  EXPECT_TRUE(within(
      T / between - 1, tol::kHeatProfile,
      {title + ": where they touch", "(e1 T1 + e2 T2) / (e1 + e2) = " + quantity(between, "K"), quantity(T, "K")}));
  ::testing::Test::RecordProperty("between", std::to_string(T));
}

TEST(HeatFlow, HalfSpacesOfOneMaterialMeet) {
  expect_half_spaces(1, BodyKind::fixed, 0.5, "D17 two half-spaces of one material");
}

TEST(HeatFlow, ABetterConductorMeets) {
  expect_half_spaces(10, BodyKind::fixed, 0.759747, "D17 two half-spaces, one conducts ten times better");
}

TEST(HeatFlow, AFluidMeetsASolid) { expect_half_spaces(1, BodyKind::fluid, 0.5, "D17 a fluid and a solid half-space"); }

TEST(HeatFlow, ASineDecays) {
  for (const double ratio : {2.0, 3.0}) {
    Scene scene = bar(0, 1);
    scene.config.periodic[0] = true;
    scene.config.numerics.support_over_spacing = ratio;
    const auto stuff = add_conductor(scene, 1);
    add_piece(scene, "body", stuff, 0, 1, 300);
    for (std::size_t i = 0; i < scene.position.size(); ++i)
      scene.temperature[i] += std::sin(2 * M_PI * scene.position[i].x());
    const auto simulation = simulate(scene);
    while (simulation->output().time < 0.05 - 1e-9) simulation->step({});
    Snapshot s;
    simulation->snapshot(s);
    double amplitude = 0;
    for (std::size_t i = 0; i < scene.position.size(); ++i)
      amplitude += 2 * (s.temperature[i] - 300) * std::sin(2 * M_PI * x_of(s, i)) / double(scene.position.size());
    const double rate = -std::log(amplitude) / simulation->output().time;
    EXPECT_TRUE(within(rate / (4 * M_PI * M_PI) - 1, tol::kHeatDecay,
                       {"D17 decay of a sine of 20 particles, H = " + quantity(ratio, "dx"),
                        "alpha k^2 = " + quantity(4 * M_PI * M_PI, "1/s"), quantity(rate, "1/s")}))
        << "H / dx = " << ratio;
    RecordProperty("rate_at_" + std::to_string(ratio), std::to_string(rate / (4 * M_PI * M_PI)));
  }
}

// Where the front is: the length of the bar that is liquid (or, for a front that freezes, solid).
double front_of(const Scene& scene, const Snapshot& s, bool solid) {
  double volume = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (!scene.bodies[scene.body[i]].holds_temperature)
      volume += scene.volume[i] * (solid ? 1 - s.liquid[i] : s.liquid[i]);
  return volume / (kDeep * kDeep);
}

// The front is at 2 lambda sqrt(t): at every time, and as the slope of a line through the later half.
void expect_front(const Scene& scene, double lambda, double until, bool solid, const std::string& title) {
  const auto simulation = simulate(scene);
  Snapshot s;
  double worst = 0, n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  while (simulation->output().time < until - 1e-9) {
    const StepOutput& out = simulation->step({});
    if (out.step % 4 != 0) continue;
    simulation->snapshot(s);
    const double front = front_of(scene, s, solid), root = std::sqrt(out.time);
    worst = std::max(worst, std::abs(front - 2 * lambda * root));
    if (out.time < until / 4) continue;
    ++n, sx += root, sy += front, sxx += root * root, sxy += root * front;
  }
  EXPECT_TRUE(within(worst / kSpacing, tol::kMeltFront,
                     {title + ": front at any time", "2 lambda sqrt(alpha t), lambda = " + quantity(lambda, ""),
                      quantity(worst / kSpacing, "dx off")}));
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  EXPECT_TRUE(within(
      slope / (2 * lambda) - 1, tol::kMeltSlope,
      {title + ": front's slope over sqrt(t)", quantity(2 * lambda, "m/sqrt(s)"), quantity(slope, "m/sqrt(s)")}));
  ::testing::Test::RecordProperty("front_off_by_spacings", std::to_string(worst / kSpacing));
  ::testing::Test::RecordProperty("slope_over_exact", std::to_string(slope / (2 * lambda)));
}

// One phase, Ste = c dT / L = 0.5: a solid at its melting temperature melts from a wall.
TEST(HeatFlow, ASolidMeltsFromAWall) {
  Scene scene = bar(-3 * kSpacing, 2);
  const auto stuff = add_conductor(scene, 1);
  scene.config.materials[stuff].melting_temperature = 273;
  scene.config.materials[stuff].latent_heat = 20;
  add_piece(scene, "wall", stuff, -3 * kSpacing, 0, 283).holds_temperature = true;
  add_piece(scene, "ice", stuff, 0, 2, 273);
  expect_front(scene, 0.464786, 0.5, false, "Stefan, one phase, melting, Ste 0.5");
}

// Two phases: a liquid above its melting temperature freezes from a wall. lambda solves
// e^-l^2 / erf l - (T0 - Tm)/(Tm - Tw) e^-l^2 / erfc l = l sqrt(pi) L / (c (Tm - Tw)): 0.5000 here.
TEST(HeatFlow, ALiquidFreezesFromAWall) {
  Scene scene = bar(-3 * kSpacing, 2.3);
  const auto stuff = add_conductor(scene, 1);
  scene.config.materials[stuff].melting_temperature = 1;
  scene.config.materials[stuff].latent_heat = 1;
  add_piece(scene, "wall", stuff, -3 * kSpacing, 0, 0.1906).holds_temperature = true;
  add_piece(scene, "liquid", stuff, 0, 2.3, 1.2);
  const double l = 0.5, e = std::exp(-l * l);
  ASSERT_NEAR(e / std::erf(l) - 0.2 / 0.8094 * e / std::erfc(l), l * std::sqrt(M_PI) / 0.8094, 1e-3);
  expect_front(scene, l, 0.5, true, "Stefan, two phases, freezing");
}

// Cools as a whole, as it conducts far better than it loses: by exp(-coefficient area t / (mass c)).
void expect_cooling(Scene scene, double area, double volume, const Tolerance& tolerance, const std::string& title) {
  scene.config.heat.loss_to_air = 0.02;
  scene.config.heat.air_temperature = 300;
  const auto simulation = simulate(scene);
  while (simulation->output().time < 1 - 1e-9) simulation->step({});
  Snapshot s;
  simulation->snapshot(s);
  double mean = 0;
  for (const float T : s.temperature) mean += T / double(s.temperature.size());
  const double rate = -std::log((mean - 300) / 100) / simulation->output().time;
  const double exact = 0.02 * area / volume;
  EXPECT_TRUE(within(rate / exact - 1, tolerance, {title, quantity(exact, "1/s"), quantity(rate, "1/s")}));
  ::testing::Test::RecordProperty("rate_over_exact", std::to_string(rate / exact));
}

TEST(HeatFlow, ASlabLosesHeatAtBothFaces) {
  Scene scene = bar(-1, 1);
  const auto stuff = add_conductor(scene, 1);
  add_piece(scene, "slab", stuff, -0.25, 0.25, 400);
  expect_cooling(scene, 2, 0.5, tol::kPlaneLoss, "Slab that loses heat to air at both faces: rate");
}

TEST(HeatFlow, ACubeLosesHeatOnAllSides) {
  Scene scene = bar(-1, 1);
  scene.config.periodic = {false, false, false};
  scene.bounds_min = {-1, -1, -1};
  scene.bounds_max = {1, 1, 1};
  const auto stuff = add_conductor(scene, 1);
  add_body(scene, "cube", BodyKind::fixed, stuff, {-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3});
  scene.temperature.assign(scene.position.size(), 400);
  expect_cooling(scene, 6 * 0.36, 0.216, tol::kCubeLoss, "Cube that loses heat to air on all sides: rate");
}

// A ball at 1 K in a shell held at 0 K: T = 2 R / (pi r) sum (-1)^(n+1) / n sin(n pi r / R) exp(-n^2 pi^2 alpha t /
// R^2) (Carslaw & Jaeger 1959, 9.3).
TEST(HeatFlow, ABallCoolsInAShell) {
  constexpr double dx = 0.1, radius = 1, shell = 1.3;
  Scene scene = empty_scene(dx, Eigen::Vector3d::Constant(-shell), Eigen::Vector3d::Constant(shell));
  scene.config.gravity.setZero();
  scene.config.rate_hz = 400;
  const auto stuff = add_conductor(scene, 1);
  const auto low = scene.config.domain_min, high = scene.config.domain_max;
  add_body(scene, "ball", BodyKind::fixed, stuff, low, high, [](const auto& x) { return x.norm() < radius; });
  scene.temperature.assign(scene.position.size(), 1);
  add_body(scene, "shell", BodyKind::fixed, stuff, low, high,
           [](const auto& x) { return x.norm() >= radius && x.norm() < shell; });
  scene.temperature.resize(scene.position.size(), 0);
  scene.bodies[1].holds_temperature = true;
  const auto simulation = simulate(scene);
  Snapshot s;
  for (const double t : {0.1, 0.2}) {
    while (simulation->output().time < t - 1e-9)
      ASSERT_TRUE(simulation->step({}).health.ok) << simulation->output().health.cause;
    simulation->snapshot(s);
    double worst = 0;
    for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i) {
      const double r = scene.position[i].norm() / radius;
      double exact = 0;
      for (int n = 1; n < 30; ++n)
        exact += (n % 2 ? 2 : -2) / (n * M_PI * r) * std::sin(n * M_PI * r) * std::exp(-n * n * M_PI * M_PI * t);
      worst = std::max(worst, std::abs(s.temperature[i] - exact));
    }
    EXPECT_TRUE(within(worst, tol::kRoundHeat,
                       {"Ball of 10 spacings that cools in a shell: profile", "series of Carslaw & Jaeger, worst place",
                        quantity(worst, "K off, of 1 K at t = ") + quantity(t, "R^2 / alpha")}));
  }
}

}  // namespace
}  // namespace palp::test::heat_flow_test
