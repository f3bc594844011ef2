// Bars of few spacings against the theory of beams: bending and torsion at rest, and their frequencies.
#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::elastic_sections_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSpacing = 0.01, kDensity = 1000, kYoung = 1e6;

// A bar, b layers wide and h high. Its axis is x of the lattice, or (skew) the diagonal of x and y, where layers lie
// closer.
struct Bar {
  int b, h;
  double poisson = 0.3;
  bool skew = false;
  double support = 2;  // H / dx

  double width() const { return b * kSpacing * (skew ? std::sqrt(0.5) : 1.0); }
  double height() const { return h * kSpacing; }
  double shear_modulus() const { return kYoung / (2 * (1 + poisson)); }
  double bending() const { return kYoung * width() * std::pow(height(), 3) / 12; }
  // Saint-Venant's torsion of a rectangle (Timoshenko & Goodier, Theory of Elasticity, 109).
  double torsion() const {
    const double a = std::max(width(), height()), c = std::min(width(), height());
    double sum = 0;
    for (int n = 1; n < 40; n += 2) sum += std::tanh(n * M_PI * a / (2 * c)) / std::pow(n, 5);
    return shear_modulus() * a * c * c * c / 3 * (1 - 192 * c / (a * std::pow(M_PI, 5)) * sum);
  }
  // To axes along the bar, across it and up.
  Matrix3d axes() const { return Eigen::AngleAxisd(skew ? -M_PI / 4 : 0, Vector3d::UnitZ()).toRotationMatrix(); }
};

std::string name_of(const Bar& bar) {
  const std::string size = std::to_string(bar.b) + "x" + std::to_string(bar.h);
  const std::string rest =
      "_nu" + std::to_string(std::lround(100 * bar.poisson)) + "_H" + std::to_string(std::lround(10 * bar.support));
  return size + rest + (bar.skew ? "_skew" : "");
}

// Few enough for every day, and more under tools/validate.
std::vector<Bar> bars() {
  std::vector<Bar> out{{4, 4}, {5, 5}, {4, 4, 0.45}, {7, 5, 0.3, true}, {4, 4, 0.3, false, 3}};
  const std::vector<Bar> more{
      {6, 6}, {8, 8}, {5, 5, 0.45}, {4, 8}, {8, 4}, {11, 8, 0.3, true}, {5, 5, 0.3, false, 3}, {8, 8, 0.3, false, 3}};
  if (validating()) out.insert(out.end(), more.begin(), more.end());
  return out;
}

Scene scene_of(const Bar& bar, double reach) {
  Scene scene = empty_scene(kSpacing, Vector3d::Constant(-reach), Vector3d::Constant(reach));
  scene.config.gravity.setZero();
  scene.config.numerics.support_over_spacing = bar.support;
  const auto rubber = add_material(scene, kDensity, 0);
  scene.config.materials[rubber].young_modulus = kYoung;
  scene.config.materials[rubber].poisson_ratio = bar.poisson;
  return scene;
}

// Adds the lattice's cells within reach whose centres, in the bar's axes, are inside.
std::uint32_t add_part(Scene& scene, const Bar& bar, const std::string& name, BodyKind kind, double reach,
                       const std::function<bool(const Vector3d&)>& inside) {
  // as many points across as the bar is wide
  const double cells = std::ceil(reach / kSpacing) * kSpacing, high = 0.5 * bar.height();
  const double side = cells + (bar.skew || bar.b % 2 == 0 ? 0.0 : 0.5 * kSpacing);
  const Matrix3d axes = bar.axes();
  return add_body(scene, name, kind, 0, {-cells, -side, -high}, {cells, side, high},
                  [&](const Vector3d& x) { return inside(axes * x); });
}

// A bar, five times as long as it is thick, that is clamped at one end and carries an arm to one side at the other, so
// that its weight bends and twists it. Body 1.
Scene with_arm(const Bar& bar) {
  const double w = std::max(bar.width(), bar.height()), length = 5 * w, reach = 5.2 * w + 5 * kSpacing;
  Scene scene = scene_of(bar, reach);
  scene.config.rate_hz = 4;  // long steps damp
  scene.config.numerics.max_speed = 0.01;
  scene.config.numerics.elastic_solver = ElasticSolver::implicit;
  scene.config.gravity = {0, 0, -0.02 * bar.height() / w / w};
  const double half = 0.5 * bar.width() + (bar.skew ? 0.1 * kSpacing : 0.0), first = -0.1 * kSpacing;
  const auto clamp = add_part(scene, bar, "clamp", BodyKind::fixed, reach, [&](const Vector3d& x) {
    return x.x() < first && x.x() > -4 * kSpacing && std::abs(x.y()) < half;
  });
  const auto body = add_part(scene, bar, "bar", BodyKind::elastic, reach, [&](const Vector3d& x) {
    const bool arm = x.x() > length - w && x.y() < 4 * w;
    return x.x() > first && x.x() < length && x.y() > -half && (x.y() < half || arm);
  });
  scene.bodies[body].bonded_to = {clamp};
  return scene;
}

// Where particles have gone, and how far, in the bar's axes.
struct Shape {
  std::vector<Vector3d> X, u;
};

Shape at_rest(const Scene& scene, const Bar& bar) {
  const auto simulation = simulate(scene);
  const Matrix3d axes = bar.axes();
  Shape shape;
  Snapshot s;
  double before = 0, now = 0;
  for (int k = 0; k < 60 && (k < 2 || std::abs(now - before) > 1e-5 * std::abs(now)); ++k) {
    EXPECT_TRUE(simulation->step({}).health.ok) << simulation->output().health.cause;
    simulation->snapshot(s);
    before = now;
    now = 0;
    for (std::size_t i = 0; i < scene.position.size(); ++i) now += s.position[3 * i + 2] - scene.position[i].z();
  }
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    if (scene.body[i] != 1) continue;
    const Vector3d x = Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>();
    shape.X.emplace_back(axes * scene.position[i]);
    shape.u.emplace_back(axes * (x - scene.position[i]));
  }
  return shape;
}

struct Layer {
  double place = 0, twist = 0, slope = 0;
};

// Returns how the layer at a place has turned about the bar's axis, and about the axis across.
Layer layer_at(const Shape& shape, double place) {
  Layer layer;
  double polar = 0, across = 0, count = 0;
  for (std::size_t i = 0; i < shape.X.size(); ++i) {
    const Vector3d &X = shape.X[i], &u = shape.u[i];
    if (std::abs(X.x() - place) > 0.55 * kSpacing) continue;
    layer.place += X.x();
    layer.twist += X.y() * u.z() - X.z() * u.y();
    layer.slope -= X.z() * u.x();
    polar += X.y() * X.y() + X.z() * X.z();
    across += X.z() * X.z();
    count += 1;
  }
  return {layer.place / count, layer.twist / polar, layer.slope / across};
}

class Section : public ::testing::TestWithParam<Bar> {};

// Moments follow from weights alone, rotations from the shape at rest; end effects die out over a thickness.
TEST_P(Section, BendsAndTwistsAsInTheory) {
  const Bar& bar = GetParam();
  const Scene scene = with_arm(bar);
  const Shape shape = at_rest(scene, bar);
  const double w = std::max(bar.width(), bar.height());
  const Layer a = layer_at(shape, 1.5 * w), b = layer_at(shape, 3.3 * w);
  double bends = 0, twists = 0;  // integrals of the moments over the length between
  constexpr int parts = 200;
  for (int k = 0; k < parts; ++k) {
    const double length = b.place - a.place, place = a.place + length * (k + 0.5) / parts;
    for (const Vector3d& X : shape.X) {
      if (X.x() < place) continue;
      const double weight = kDensity * scene.volume.back() * scene.config.gravity.z();
      bends += length / parts * weight * (X.x() - place);
      twists += length / parts * weight * X.y();
    }
  }
  const auto judge = [&](const std::string& what, double found, double exact) {
    EXPECT_TRUE(within(found / exact - 1, tol::kSectionStiffness,
                       {"bar of " + name_of(bar) + ": " + what, quantity(exact, "N m^2"), quantity(found, "N m^2")}));
  };
  judge("stiffness in bending", bends / (b.slope - a.slope), bar.bending());
  judge("stiffness in torsion", twists / (b.twist - a.twist), bar.torsion());
}

// Returns the frequency of the cosine about 0 that fits best.
double frequency_of(const std::vector<double>& t, const std::vector<double>& y, double expected) {
  double best = 1e30, found = 0;
  for (double f = 0.6 * expected; f < 1.4 * expected; f *= 1.0005) {
    Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < t.size(); ++k) {
      const Eigen::Vector2d basis(std::cos(2 * M_PI * f * t[k]), std::sin(2 * M_PI * f * t[k]));
      moments += basis * basis.transpose();
      right += y[k] * basis;
    }
    const double left = -right.dot(moments.inverse() * right);  // of the sum of squares, which is the same for all
    if (left < best) best = left, found = f;
  }
  return found;
}

// A free bar, ten times as long as it is high, in its first mode.
struct FreeBar {
  Bar bar;
  bool twists;

  double length() const { return 10 * bar.height(); }
  // Theory: ASTM E1876 with shear and rotary inertia in it, and that of a shaft.
  double frequency() const {
    const double h = bar.height(), b = bar.width(), nu = bar.poisson, r2 = std::pow(h / length(), 2);
    const double polar = kDensity * b * h * (b * b + h * h) / 12;
    if (twists) return std::sqrt(bar.torsion() / polar) / (2 * length());
    const double T =
        1 + 6.585 * (1 + 0.0752 * nu + 0.8109 * nu * nu) * r2 - 0.868 * r2 * r2 -
        8.340 * (1 + 0.2023 * nu + 2.173 * nu * nu) * r2 * r2 / (1 + 6.338 * (1 + 0.1408 * nu + 1.536 * nu * nu) * r2);
    return std::sqrt(kYoung * h * h / (0.9465 * kDensity * std::pow(length(), 4) * T));
  }
  Vector3d mode(const Vector3d& X) const {
    if (twists) return std::sin(M_PI * X.x() / length()) * Vector3d(0, -X.z(), X.y());
    const double k = 4.7300 / length(), c = std::cos(0.5 * k * length()) / std::cosh(0.5 * k * length());
    const double slope = k * (c * std::sinh(k * X.x()) - std::sin(k * X.x()));
    return {-slope * X.z(), 0, std::cos(k * X.x()) + c * std::cosh(k * X.x())};
  }
};

double frequency_by(ElasticSolver solver, const FreeBar& free) {
  const Vector3d half = 0.5 * Vector3d(free.length(), free.bar.width(), free.bar.height());
  const double expected = free.frequency();
  Scene scene = scene_of(free.bar, 6 * free.bar.height());
  scene.config.numerics.elastic_solver = solver;
  add_body(scene, "bar", BodyKind::elastic, 0, -half, half);
  double size = 0;
  for (const Vector3d& X : scene.position) size = std::max(size, free.mode(X).norm());
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    scene.velocity[i] = 0.01 * kSpacing * 2 * M_PI * expected / size * free.mode(scene.position[i]);
  // backward Euler lengthens a period by (w dt)^2 / 3: 6e-4
  scene.config.rate_hz = std::ceil((solver == ElasticSolver::implicit ? 150 : 40) * expected);
  scene.config.numerics.max_speed = 0.5;
  const auto simulation = simulate(scene);
  std::vector<double> t, y;
  Snapshot s;
  while (simulation->output().time < 1.5 / expected) {
    EXPECT_TRUE(simulation->step({}).health.ok) << simulation->output().health.cause;
    simulation->snapshot(s);
    double sum = 0;
    for (std::size_t i = 0; i < scene.position.size(); ++i) {
      const Vector3d x = Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>();
      sum += free.mode(scene.position[i]).dot(x - scene.position[i]);
    }
    t.push_back(simulation->output().time);
    y.push_back(sum);
  }
  return frequency_of(t, y, expected);
}

TEST_P(Section, SwingsAsInTheoryByEitherSolver) {
  const Bar& bar = GetParam();
  if (bar.skew) GTEST_SKIP() << "bars along the diagonal end in steps";
  for (const bool twists : {false, true}) {
    const FreeBar free{bar, twists};
    std::array<double, 2> found{};
    for (const auto solver : {ElasticSolver::explicit_, ElasticSolver::implicit}) {
      if (solver == ElasticSolver::implicit && bar.b * bar.h > 16 && !validating()) continue;
      const double f = found[static_cast<std::size_t>(solver)] = frequency_by(solver, free);
      EXPECT_TRUE(within(f / free.frequency() - 1, twists ? tol::kTwistFrequency : tol::kSectionFrequency,
                         {"free bar of " + name_of(bar) + (twists ? ": torsion" : ": bending") + ", first frequency",
                          quantity(free.frequency(), "Hz"), quantity(f, "Hz")}));
    }
    if (found[1] > 0) {
      EXPECT_TRUE(within(found[1] / found[0] - 1, tol::kSolversFrequency));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Bars, Section, ::testing::ValuesIn(bars()),
                         [](const auto& param) { return name_of(param.param); });

}  // namespace
}  // namespace palp::test::elastic_sections_test
