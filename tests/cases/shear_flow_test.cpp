// Viscosity: start-up of plane Couette and Poiseuille flow (Morris, Fox & Zhu 1997) and the decay of Taylor's vortices.
// In units of the channel: its height is 1 m and nu = 1 m^2/s, so times are in L^2 / nu.
#include <functional>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::shear_flow_test {
namespace {

constexpr double kSpacing = 0.1;
constexpr const char* kPapersWall =
    "Eq. 3 as it stands: wall particles take part with the wall's own velocity, which does not place its surface";

class ShearFlow : public ::testing::TestWithParam<Method> {};

Scene channel(Method method) {
  constexpr double deep = 9 * kSpacing, wall = 3 * kSpacing;
  Scene scene = empty_scene(kSpacing, {0, 0, -wall}, {deep, deep, 1 + wall});
  SceneConfig& config = scene.config;
  config.periodic = {true, true, false};
  config.method = method;
  config.gravity.setZero();
  config.rate_hz = 800;
  config.numerics.support_over_spacing = 3;
  config.numerics.artificial_viscosity = 0;
  config.numerics.max_speed = 1;
  const auto oil = add_material(scene, 1000, 1000);
  const ByGeometry walls;
  add_body(scene, "oil", BodyKind::fluid, oil, {0, 0, 0}, {deep, deep, 1});
  add_body(scene, "bottom", BodyKind::fixed, oil, {0, 0, -wall}, {deep, deep, 0});
  add_body(scene, "top", BodyKind::fixed, oil, {0, 0, 1}, {deep, deep, 1 + wall});
  return scene;
}

// Largest difference of the particles' speed from the profile, at the times of Morris et al.
void expect_profile(const Scene& scene, double scale, const std::string& title,
                    const std::function<double(double z, double t)>& speed) {
  const auto simulation = simulate(scene);
  Snapshot s;
  for (double t : {0.0225, 0.045, 0.1125, 0.225, 1.0}) {
    const StepOutput* out = nullptr;
    do {
      out = &simulation->step({});
      ASSERT_TRUE(out->health.ok) << out->health.cause;
    } while (out->time < t - 1e-9);
    simulation->snapshot(s);
    double worst = 0;
    for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i)
      worst = std::max(worst, std::abs(s.velocity[3 * i] - speed(s.position[3 * i + 2], out->time)));
    EXPECT_TRUE(within(worst / scale, tol::kShearFlow,
                       {title, "series of Morris, Fox & Zhu 1997; worst of t = 0.0225 to 1 L^2/nu",
                        quantity(worst, "m/s off at t = ") + quantity(t, "L^2/nu"), scene.config.method, kPapersWall}))
        << "t = " << t;
    ::testing::Test::RecordProperty("error_at_" + std::to_string(t), std::to_string(worst / scale));
  }
}

TEST_P(ShearFlow, CouetteStartsUp) {
  Scene scene = channel(GetParam());
  scene.bodies[2].velocity = {1, 0, 0};
  for (std::uint32_t i = 0; i < scene.bodies[2].count; ++i) scene.velocity[scene.bodies[2].first + i].x() = 1;
  expect_profile(
      scene, 0.5, "D4 Couette flow starting up: worst speed, of 0.5 m/s in the middle", [](double z, double t) {
        double u = z;
        for (int n = 1; n < 60; ++n)
          u += 2 / (n * M_PI) * (n % 2 ? -1 : 1) * std::sin(n * M_PI * z) * std::exp(-n * n * M_PI * M_PI * t);
        return u;
      });
}

TEST_P(ShearFlow, PoiseuilleStartsUp) {
  Scene scene = channel(GetParam());
  scene.config.body_force = {8, 0, 0};  // 1 m/s in the middle
  expect_profile(scene, 1, "D4 Poiseuille flow starting up: worst speed, of 1 m/s in the middle",
                 [](double z, double t) {
                   double u = 4 * z * (1 - z);
                   for (int n = 0; n < 30; ++n) {
                     const double k = 2 * n + 1;
                     u -= 32 / std::pow(M_PI * k, 3) * std::sin(M_PI * k * z) * std::exp(-k * k * M_PI * M_PI * t);
                   }
                   return u;
                 });
}

// u = U sin(2 pi x) cos(2 pi z) e^(-8 pi^2 nu t), Re = 20: the energy falls with twice that rate. That holds while the
// particles keep their order. Once the flow has stretched their lattice at its stagnation points they fall into
// disorder, and at 20 particles a box this takes energy too: measured, 1.6 times the exact rate over 0.3 s. What is
// promised is the start, and that energy only falls.
TEST_P(ShearFlow, TaylorGreenVorticesDecay) {
  constexpr double fine = 0.05, deep = 9 * fine, nu = 0.05;
  Scene scene = empty_scene(fine, {0, 0, 0}, {1, deep, 1});
  scene.config.periodic = {true, true, true};
  scene.config.method = GetParam();
  scene.config.gravity.setZero();
  scene.config.numerics.support_over_spacing = 3;
  scene.config.numerics.artificial_viscosity = 0;
  scene.config.numerics.max_speed = 1;
  scene.config.rate_hz = 200;
  const auto oil = add_material(scene, 1000, 1000 * nu);
  add_body(scene, "oil", BodyKind::fluid, oil, {0, 0, 0}, {1, deep, 1});
  double before = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const double x = 2 * M_PI * scene.position[i].x(), z = 2 * M_PI * scene.position[i].z();
    scene.velocity[i] = {std::sin(x) * std::cos(z), 0, -std::cos(x) * std::sin(z)};
    before += 0.5 * 1000 * scene.volume[i] * scene.velocity[i].squaredNorm();
  }
  const auto simulation = simulate(scene);
  const double expected = 16 * M_PI * M_PI * nu;
  double last = before;
  for (int k = 1; k <= 60; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    const double energy = out.health.kinetic_energy, rate = std::log(before / energy) / out.time;
    if (k == 20) {
      EXPECT_TRUE(within(rate / expected - 1, tol::kTaylorGreen,
                         {"D5 Taylor-Green vortices: decay of energy over 0.1 s, Re 20",
                          "16 pi^2 nu = " + quantity(expected, "1/s"), quantity(rate, "1/s"), GetParam()}));
    }
    if (k % 20 == 0) RecordProperty("rate_over_exact_at_" + std::to_string(out.time), std::to_string(rate / expected));
    EXPECT_LT(energy, last) << "at " << out.time << " s";
    last = energy;
  }
}

// The same at Re 100, as long as particles that nothing keeps evenly spread need to break up: they would take 3.7 times
// the exact rate in the first half of a second and 1.25 times it in the second from a lattice, 1.2 and 1.04 times it
// where they begin displaced by up to a quarter of a spacing.
class Vortices : public ::testing::TestWithParam<double> {};

TEST_P(Vortices, DecayAtTheirRateForASecond) {
  constexpr int across = 25;
  constexpr double fine = 1.0 / across, deep = 12 * fine, nu = 0.01;
  Scene scene = empty_scene(fine, {0, 0, 0}, {1, deep, 1});
  scene.config.periodic = {true, true, true};
  scene.config.gravity.setZero();
  scene.config.accuracy = Accuracy::accurate;
  scene.config.numerics.sound_speed = 10;
  scene.config.rate_hz = 1000;
  add_body(scene, "oil", BodyKind::fluid, add_material(scene, 1000, 1000 * nu), {0, 0, 0}, {1, deep, 1});
  Random random(1);
  double start = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    scene.position[i] += random_vector(random, GetParam() * fine);
    const double x = 2 * M_PI * scene.position[i].x(), z = 2 * M_PI * scene.position[i].z();
    scene.velocity[i] = {std::sin(x) * std::cos(z), 0, -std::cos(x) * std::sin(z)};
    start += 0.5 * 1000 * scene.volume[i] * scene.velocity[i].squaredNorm();
  }
  const auto simulation = simulate(scene);
  const double expected = 16 * M_PI * M_PI * nu;
  for (const char* half : {"first", "second"}) {
    double end = 0;
    for (int k = 0; k < 500; ++k) {
      const StepOutput& out = simulation->step({});
      ASSERT_TRUE(out.health.ok) << out.health.cause;
      end = out.health.kinetic_energy;
    }
    const double rate = 2 * std::log(start / end);
    EXPECT_TRUE(within(rate / expected - 1, tol::kVortices,
                       {std::string("D5 Taylor-Green vortices: decay of energy, ") + half +
                            " half of a second, Re 100, " + (GetParam() > 0 ? "displaced" : "from a lattice"),
                        "16 pi^2 nu = " + quantity(expected, "1/s"), quantity(rate, "1/s"), Method::accurate}));
    start = end;
  }
}

INSTANTIATE_TEST_SUITE_P(Starts, Vortices, ::testing::Values(0, 0.25),
                         [](const auto& param) { return param.param > 0 ? "displaced" : "lattice"; });

INSTANTIATE_TEST_SUITE_P(Methods, ShearFlow, ::testing::ValuesIn(methods()),
                         [](const auto& param) { return to_string(param.param); });

// A film runs down a slope of 30 degrees under its own weight: g sin(theta) z (2 h - z) / (2 nu) (Nusselt 1916).
class FilmFlow : public ::testing::TestWithParam<Method> {};

TEST_P(FilmFlow, RunsDownASlope) {
  constexpr double dx = 0.01, h = 10 * dx, side = 8 * dx, nu = 0.05, along = 9.81 * 0.5;
  Scene scene = empty_scene(dx, {0, 0, -4 * dx}, {side, side, 2 * h});
  scene.config.periodic = {true, true, false};
  scene.config.accuracy = Accuracy::fast;
  scene.config.method = GetParam();
  scene.config.gravity = {along, 0, -9.81 * std::sqrt(0.75)};
  scene.config.numerics.max_speed = 1;
  const auto oil = add_material(scene, 1000, 1000 * nu);
  const auto film = add_body(scene, "film", BodyKind::fluid, oil, {0, 0, 0}, {side, side, h});
  add_body(scene, "plate", BodyKind::fixed, oil, {0, 0, -4 * dx}, {side, side, 0});
  const auto simulation = simulate(scene);
  while (simulation->output().time < 3 * h * h / nu)
    ASSERT_TRUE(simulation->step({}).health.ok) << simulation->output().health.cause;
  Snapshot s;
  simulation->snapshot(s);
  const double surface = along * h * h / (2 * nu);
  double worst = 0;
  for (std::uint32_t i = 0; i < scene.bodies[film].count; ++i) {
    const double z = s.position[3 * i + 2];
    worst = std::max(worst, std::abs(s.velocity[3 * i] - along * z * (2 * h - z) / (2 * nu)));
  }
  EXPECT_TRUE(within(
      worst / surface, tol::kFilmFlow,
      {"Film that runs down a slope of 30 deg: worst speed, of " + quantity(surface, "m/s"),
       "g sin(theta) z (2 h - z) / (2 nu) (Nusselt 1916)", quantity(worst, "m/s off"), GetParam(), kPapersWall}));
}

INSTANTIATE_TEST_SUITE_P(Methods, FilmFlow, ::testing::ValuesIn(methods()),
                         [](const auto& param) { return to_string(param.param); });

}  // namespace
}  // namespace palp::test::shear_flow_test
