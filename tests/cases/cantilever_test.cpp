// Elastic bodies against beam theory: the plate of the scene "cantilever", and a column whose middle is a tensile test.
#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scene_files.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::cantilever_test {
namespace {

// The best fit of a + b cos(w t) + c sin(w t) to a curve; the sum of squares that it leaves.
double fit(const std::vector<double>& t, const std::vector<double>& y, double w, Eigen::Vector3d& abc) {
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const auto basis = [&](std::size_t k) { return Eigen::Vector3d(1, std::cos(w * t[k]), std::sin(w * t[k])); };
  for (std::size_t k = 0; k < t.size(); ++k) {
    moments += basis(k) * basis(k).transpose();
    right += y[k] * basis(k);
  }
  abc = moments.inverse() * right;
  double left = 0;
  for (std::size_t k = 0; k < t.size(); ++k) left += std::pow(basis(k).dot(abc) - y[k], 2);
  return left;
}

constexpr const char* kPapersStiffness =
    "gradients are not corrected: stiffness depends on the kernel and on surfaces near by";

// How the middle of a bar's free end moves.
struct Tip {
  std::vector<double> time, along, down;
  std::string diverged;  // where it did, and nothing else counts

  // Returns the text for the table: the result, or that it diverged.
  std::string told(const std::string& found) const { return diverged.empty() ? found : diverged; }
};

// Half way between the extremes, and half the way between them.
struct Range {
  double mean, amplitude;
};

Range range_of(const std::vector<double>& y) {
  const auto [low, high] = std::minmax_element(y.begin(), y.end());
  return {0.5 * (*high + *low), 0.5 * (*high - *low)};
}

// Returns how the middle of body 1's end at x = length has moved. The end is half a spacing beyond its outermost
// particles.
Eigen::Vector3d end_of(const Scene& scene, const Snapshot& s, double length) {
  const Body& body = scene.bodies[1];
  std::array<Eigen::Vector3d, 2> layer{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  std::array<int, 2> count{};
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
    const auto from_end = static_cast<std::size_t>((length - scene.position[i].x()) / scene.spacing);
    if (from_end > 1) continue;
    layer[from_end] += Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>() - scene.position[i];
    ++count[from_end];
  }
  return 1.5 * layer[0] / count[0] - 0.5 * layer[1] / count[1];
}

// Watches the tip of body 1, which ends at x = length.
Tip watch_tip(const Scene& scene, double length, double until) {
  const auto simulation = simulate(scene);
  Tip tip;
  Snapshot s;
  while (simulation->output().time < until) {
    const StepOutput& out = simulation->step({});
    if (!out.health.ok) {
      tip.diverged = "diverged at " + quantity(out.time, "s");
      return tip;
    }
    if (out.step % 4 != 0) continue;
    simulation->snapshot(s);
    const Eigen::Vector3d end = end_of(scene, s, length);
    tip.time.push_back(out.time);
    tip.along.push_back(end.x());
    tip.down.push_back(-end.z());
  }
  return tip;
}

// The cosine that fits best, about its mean; no numbers where it diverged.
struct Swing {
  double mean = NAN, period = NAN;
};

Swing swing_of(const Tip& tip, double expected_period) {
  Swing swing;
  if (!tip.diverged.empty()) return swing;
  double best = 1e30;
  for (double w = M_PI / expected_period; w < 4 * M_PI / expected_period; w *= 1.001) {
    Eigen::Vector3d abc;
    const double left = fit(tip.time, tip.down, w, abc);
    if (left >= best) continue;
    best = left;
    swing = {abc.x(), 2 * M_PI / w};
  }
  return swing;
}

struct Rubber {
  double young = 2e6, poisson = 0.3975;
};

// A bar, size.z() high, from a clamp at x < 0, which has let go of it at t = 0. A plate goes on across for ever.
Scene clamped(Method method, double dx, const Eigen::Vector3d& size, bool plate, double gravity, const Rubber& of) {
  Scene scene = empty_scene(dx, {-0.25 * size.x(), plate ? 0 : -size.x(), -size.x()},
                            {1.25 * size.x(), plate ? size.y() : size.x(), size.x()});
  scene.config.method = method;
  scene.config.periodic = {false, plate, false};
  scene.config.gravity = {0, 0, -gravity};
  scene.config.numerics.support_over_spacing = 2;
  const auto rubber = add_material(scene, 1000, 0);
  scene.config.materials[rubber].young_modulus = of.young;
  scene.config.materials[rubber].poisson_ratio = of.poisson;
  const auto clamp = add_body(scene, "clamp", BodyKind::fixed, rubber, {-5 * dx, 0, 0}, {0, size.y(), size.z()});
  const auto bar = add_body(scene, "bar", BodyKind::elastic, rubber, {0, 0, 0}, size);
  scene.bodies[bar].bonded_to = {clamp};
  return scene;
}

constexpr double kHigh = 0.02, kFine = kHigh / 10, kAcross = 6;  // [m]; a plate's period, in spacings

class Cantilever : public ::testing::TestWithParam<Method> {};

// The scene "cantilever" with ten particles over the plate's thickness, as short across as its period may be. Released
// straight, it swings about its sag: the mean is what Turek & Hron's CSM1 asks, the period what Gray, Monaghan & Swift
// 2001 ask, of a thin plate without end across.
TEST_P(Cantilever, PlateSwingsAboutItsSag) {
  constexpr double length = 0.2, gravity = 0.2, free = length, k = 1.875 / free;
  const Rubber rubber;
  const double in_plane = rubber.young / (1 - rubber.poisson * rubber.poisson);
  const double sag = 3 * 1000 * gravity * std::pow(free, 4) / (2 * in_plane * kHigh * kHigh);
  const double period = 2 * M_PI / std::sqrt(in_plane * kHigh * kHigh * std::pow(k, 4) / (12 * 1000));
  const Scene scene = clamped(GetParam(), kFine, {length, kAcross * kFine, kHigh}, true, gravity, rubber);
  const Tip tip = watch_tip(scene, length, 1.1 * period);
  const Swing found = swing_of(tip, period);
  EXPECT_TRUE(within(found.mean / sag - 1, tol::kPlateSag,
                     {"D11 clamped plate, own weight, h = 10 dx: sag at the tip",
                      "3 rho g L^4 / (2 E' h^2) = " + quantity(1e3 * sag, "mm"),
                      tip.told(quantity(1e3 * found.mean, "mm")), GetParam(), kPapersStiffness}));
  EXPECT_TRUE(within(found.period / period - 1, tol::kPlatePeriod,
                     {"D12 clamped plate, h = 10 dx: period", quantity(period, "s (thin plate; Gray 2001)"),
                      tip.told(quantity(found.period, "s")), GetParam(), kPapersStiffness}));
}

// The narrow form of D11: a bar with free sides bends with E itself. It is short, so that shear counts (Cowper 1966).
TEST_P(Cantilever, BarSwingsAboutItsSag) {
  constexpr double length = 0.12, gravity = 1, free = length;
  const Rubber rubber;
  const double shear = 10 * (1 + rubber.poisson) / (12 + 11 * rubber.poisson) * rubber.young / 2 / (1 + rubber.poisson);
  const double sag = 1000 * gravity * free * free * (1.5 * free * free / (rubber.young * kHigh * kHigh) + 0.5 / shear);
  const double period = 2 * M_PI / std::pow(1.875 / free, 2) * std::sqrt(12 * 1000 / rubber.young) / kHigh;
  const Scene scene = clamped(GetParam(), kFine, {length, kHigh, kHigh}, false, gravity, rubber);
  const Tip tip = watch_tip(scene, length, 1.1 * period);
  const Swing found = swing_of(tip, period);
  EXPECT_TRUE(within(found.mean / sag - 1, tol::kPlateSag,
                     {"D11 clamped bar with free sides, own weight, h = 10 dx: sag at the tip",
                      "3 rho g L^4 / (2 E h^2) and shear, " + quantity(1e3 * sag, "mm"),
                      tip.told(quantity(1e3 * found.mean, "mm")), GetParam(), kPapersStiffness}));
}

INSTANTIATE_TEST_SUITE_P(Methods, Cantilever, ::testing::ValuesIn(methods()),
                         [](const auto& param) { return to_string(param.param); });

// Turek & Hron 2006, CSM3 (6468 unknowns): a bar that is let go and falls to more than a third of its length, in plane
// strain. They give the displacement of the end's middle as mean +- amplitude [frequency].
class TurekHron : public ::testing::TestWithParam<int> {};

TEST_P(TurekHron, BarSwingsFarAsInCsm3) {
  const int across = GetParam();
  const double dx = kHigh / across, length = 0.35, frequency = 1.0995;
  const Scene scene =
      clamped(Method::accurate, dx, {length, kAcross * dx, kHigh}, true, 2, {.young = 1.4e6, .poisson = 0.4});
  const Tip tip = watch_tip(scene, length, 2.1 / frequency);
  ASSERT_EQ(tip.diverged, "");
  const auto judge = [&](const std::string& what, double found, double expected, double scale,
                         const std::string& unit) {
    EXPECT_TRUE(within(found / expected - 1, tol::kCsm3,
                       {"D11 Turek & Hron's CSM3, h = " + std::to_string(across) + " dx: " + what,
                        quantity(scale * expected, unit), quantity(scale * found, unit)}));
  };
  const Range down = range_of(tip.down);
  judge("mean sag of the tip", down.mean, 63.541e-3, 1e3, "mm");
  judge("amplitude of the tip", down.amplitude, 65.094e-3, 1e3, "mm");
  judge("mean shortening, which goes with the square", -range_of(tip.along).mean, 14.279e-3, 1e3, "mm");
  judge("frequency", 1 / swing_of(tip, 1 / frequency).period, frequency, 1, "Hz");
}

// CSM1: the same bar at rest, by the implicit solver, whose long steps damp.
TEST_P(TurekHron, BarSagsAsInCsm1) {
  const int across = GetParam();
  const double dx = kHigh / across, length = 0.35;
  Scene scene = clamped(Method::accurate, dx, {length, kAcross * dx, kHigh}, true, 2, {.young = 1.4e6, .poisson = 0.4});
  scene.config.rate_hz = 10;
  scene.config.numerics.max_speed = 0.02;
  scene.config.numerics.elastic_solver = ElasticSolver::implicit;
  const auto simulation = simulate(scene);
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  Snapshot s;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(simulation->step({}).health.ok) << simulation->output().health.cause;
    simulation->snapshot(s);
    const Eigen::Vector3d before = end;
    end = end_of(scene, s, length);
    if (k > 5 && (end - before).norm() < 1e-6) break;
  }
  const auto judge = [&](const std::string& what, double found, double expected) {
    EXPECT_TRUE(within(found / expected - 1, tol::kCsm3,
                       {"D11 Turek & Hron's CSM1, h = " + std::to_string(across) + " dx: " + what,
                        quantity(1e3 * expected, "mm"), quantity(1e3 * found, "mm")}));
  };
  judge("sag of the tip", -end.z(), 66.10e-3);
  judge("shortening", -end.x(), 7.187e-3);
}

INSTANTIATE_TEST_SUITE_P(Spacings, TurekHron, ::testing::Values(5, 8));

class UniaxialBar : public ::testing::TestWithParam<Method> {};

// Slope of one displacement over one place, over the particles within `reach` of the middle along x.
double slope(const Scene& scene, const Snapshot& s, double middle, double reach, int axis) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    if (scene.body[i] != 1 || std::abs(scene.position[i].x() - middle) > reach) continue;
    const double x = scene.position[i][axis], u = s.position[3 * i + static_cast<std::size_t>(axis)] - x;
    ++n, sx += x, sy += u, sxx += x * x, sxy += x * u;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

// A column that hangs by one end: through its middle goes the weight of the half below, whatever the clamp does.
TEST_P(UniaxialBar, StretchesAndNarrowsByItsConstants) {
  constexpr double dx = 0.01, across = 10 * dx, length = 24 * dx, young = 1e5, nu = 0.3, g = 9.81;
  Scene scene = empty_scene(dx, {-1, -1, -1}, {1, 1, 1});
  scene.config.method = GetParam();
  scene.config.gravity = {-g, 0, 0};
  scene.config.gravity_ramp = 0.3;
  scene.config.numerics.support_over_spacing = 2;
  const auto rubber = add_material(scene, 1000, 0);
  scene.config.materials[rubber].young_modulus = young;
  scene.config.materials[rubber].poisson_ratio = nu;
  scene.config.materials[rubber].damping = 6;
  const auto clamp =
      add_body(scene, "clamp", BodyKind::fixed, rubber, {length, 0, 0}, {length + 3 * dx, across, across});
  const auto bar = add_body(scene, "bar", BodyKind::elastic, rubber, {0, 0, 0}, {length, across, across});
  scene.bodies[bar].bonded_to = {clamp};
  const auto simulation = simulate(scene);
  // what is left of its swing has a period of 4 L / c = 0.1 s
  run_until(*simulation, 0.4);
  Snapshot s;
  double along = 0, sideways = 0;
  for (int k = 0; k < 20; ++k) {
    run_until(*simulation, 0.4 + 0.01 * (k + 1));
    ASSERT_TRUE(simulation->output().health.ok);
    simulation->snapshot(s);
    along += slope(scene, s, 0.5 * length, 4 * dx, 0) / 20;
    for (int axis : {1, 2}) sideways += slope(scene, s, 0.5 * length, 1.1 * dx, axis) / 40;
  }
  const double stress = 1000 * g * 0.5 * length;
  EXPECT_TRUE(
      within(stress / along / young - 1, tol::kYoung,
             {"D9 middle of a hanging column, 10 x 10 across: Young's modulus", "E = " + quantity(1e-3 * young, "kPa"),
              quantity(1e-3 * stress / along, "kPa"), GetParam(), kPapersStiffness}));
  EXPECT_TRUE(within(-sideways / along / nu - 1, tol::kPoisson,
                     {"D9 middle of a hanging column, 10 x 10 across: Poisson's ratio", "nu = " + quantity(nu, ""),
                      quantity(-sideways / along, ""), GetParam(), kPapersStiffness}));
}

INSTANTIATE_TEST_SUITE_P(Methods, UniaxialBar, ::testing::ValuesIn(methods()),
                         [](const auto& param) { return to_string(param.param); });

}  // namespace
}  // namespace palp::test::cantilever_test
