// Scenes that a user may write and no textbook has: bodies of a particle or three, of loose particles nearly on
// top of each other, bodies a little in one another, materials at the ends of their ranges, absolute zero. Each is read
// from a file, as any scene is, and simulated to something finite (physics reference F).

#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/files.h"
#include "tests/support/tolerance.h"

namespace palp::test::degenerate_bodies_test {
namespace {

constexpr double kSpacing = 0.02, kHeight = 0.1, kGravity = 9.81;

struct Matter {
  const char* name;
  const char* type;      // of the body
  const char* material;  // keys beside the density
  double temperature;    // 0: none
  bool paper;            // whether method "paper" knows it
};

constexpr const char* kMelts =
    "young_modulus = 1e5\nviscosity = 0.1\nheat_capacity = 2000\nconductivity = 1\nmelting_temperature = 273\n"
    "latent_heat = 3e4\n";

const Matter kMatter[] = {
    {"fluid", "fluid", "viscosity = 0.1\n", 0, true},
    {"elastic", "elastic", "young_modulus = 1e5\n", 0, true},
    {"plastic", "elastic", "young_modulus = 1e5\nyield_stress = 1e3\ntear_strain = 0.5\n", 0, false},
    {"rigid", "rigid", "", 0, true},
    {"ice", "elastic", kMelts, 260, true},
    {"freezing water", "fluid", kMelts, 273.01, true},
    {"rigid ice", "elastic",
     "young_modulus = 1e5\nviscosity = 0.1\nheat_capacity = 2000\nconductivity = 1\nmelting_temperature = 273\n"
     "latent_heat = 3e4\nrigid_below = 265\n",
     260, true},
};

class OddBodies : public ::testing::TestWithParam<Method> {
 protected:
  std::string csv(const std::vector<Eigen::Vector3d>& places) {
    std::ofstream out(folder_ / "loose.csv");
    out << "x,y,z\n";
    for (const Eigen::Vector3d& x : places) out << x.x() << ',' << x.y() << ',' << x.z() << '\n';
    return "type = \"particles\"\nfile = \"loose.csv\"\n";
  }

  static std::string body(const Matter& matter, const std::string& name, const std::string& shape,
                          const Eigen::Vector3d& at) {
    std::string text = "[[body]]\nname = \"" + name + "\"\ntype = \"" + matter.type + "\"\nmaterial = \"m\"\n";
    text += "position = [" + std::to_string(at.x()) + ", " + std::to_string(at.y()) + ", " + std::to_string(at.z());
    text += "]\n";
    if (matter.temperature > 0) text += "temperature = " + std::to_string(matter.temperature) + "\n";
    return text + "[[body.shape]]\n" + shape;
  }

  // Over a floor whose top is at z = 0, as warm as the body or a little colder.
  Scene scene(const Matter& matter, const std::string& bodies, const std::string& more = "") {
    std::ofstream out(folder_ / "odd.toml");
    out << "[scene]\naccuracy = \"fast\"\n[domain]\nmin = [-0.3, -0.3, -0.1]\nmax = [0.3, 0.3, 0.5]\n"
        << "[numerics]\nspacing = " << kSpacing << "\n[[material]]\nname = \"m\"\ndensity = 1000\n"
        << matter.material << "[[material]]\nname = \"stone\"\ndensity = 2000\nheat_capacity = 800\nconductivity = 1\n"
        << "[[body]]\nname = \"floor\"\ntype = \"static\"\nmaterial = \"stone\"\n"
        << (matter.temperature > 0 ? "temperature = 260\n" : "")
        << "[[body.shape]]\ntype = \"box\"\nsize = [0.24, 0.24, 0.06]\nposition = [0, 0, -0.03]\n"
        << bodies << more;
    out.close();
    SceneOverrides overrides;
    overrides.method = GetParam();
    return sample_scene(load_scene(folder_ / "odd.toml", overrides), 100000);
  }

  bool known(const Matter& matter) const { return matter.paper || GetParam() == Method::accurate; }

  ScratchFolder folder_;
};

// Steps until a time; false, and a failure, where the simulation is not healthy or a place is no number.
::testing::AssertionResult runs_until(Simulation& simulation, double time, Snapshot& s) {
  while (simulation.output().time < time - 1e-9) {
    const Health& health = simulation.step({}).health;
    if (!health.ok) return ::testing::AssertionFailure() << health.cause << " at " << simulation.output().time << " s";
  }
  simulation.snapshot(s);
  for (const std::vector<float>* field : {&s.position, &s.velocity, &s.temperature})
    for (const float value : *field)
      if (!std::isfinite(value)) return ::testing::AssertionFailure() << "not finite";
  return ::testing::AssertionSuccess();
}

// A particle, two, three in a row, three and five in a plane fall like stones, those of fluids apart from the push of
// the pressure that they begin with. What the floor then does with them is another matter: so few have no density.
TEST_P(OddBodies, ThoseOfAFewParticlesFallLikeStones) {
  const std::vector<std::vector<Eigen::Vector3d>> sets{
      {{0, 0, 0}},
      {{0, 0, 0}, {1, 0, 0}},
      {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}},
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 2, 0}},
  };
  for (const Matter& matter : kMatter)
    for (std::vector<Eigen::Vector3d> places : sets) {
      if (!known(matter)) continue;
      SCOPED_TRACE(std::string(matter.name) + ", " + std::to_string(places.size()) + " particles");
      for (Eigen::Vector3d& x : places) x *= kSpacing;
      const Scene odd = scene(matter, body(matter, "odd", csv(places), {0, 0, kHeight}));
      const auto simulation = simulate(odd);
      Snapshot s;
      ASSERT_TRUE(runs_until(*simulation, 0.1, s));
      for (std::size_t i = odd.bodies[1].first; i < odd.position.size(); ++i) {
        EXPECT_TRUE(within(s.velocity[3 * i + 2] + kGravity * simulation->output().time, tol::kCrumbFall));
        if (std::string(matter.type) == "fluid") continue;
        EXPECT_TRUE(within(std::hypot(s.velocity[3 * i], s.velocity[3 * i + 1]), tol::kCrumbFall));
      }
      ASSERT_TRUE(runs_until(*simulation, 0.4, s));
    }
}

// Loose particles of a fluid as near as a scene may have them part, and nothing else happens.
TEST_P(OddBodies, NearlyCoincidentParticlesStayFinite) {
  std::vector<Eigen::Vector3d> places;
  for (const int z : {0, 1, 2, 3})
    for (const int y : {0, 1, 2, 3})
      for (const int x : {0, 1, 2, 3}) places.push_back(kSpacing * Eigen::Vector3d(x, y, z));
  places.push_back(places[21] + 0.002 * kSpacing * Eigen::Vector3d(0.6, 0.8, 0));
  for (const Matter& matter : kMatter) {
    if (!known(matter) || std::string(matter.type) != "fluid") continue;
    SCOPED_TRACE(matter.name);
    const Scene odd = scene(matter, body(matter, "odd", csv(places), {0, 0, kHeight}));
    Snapshot s;
    EXPECT_TRUE(runs_until(*simulate(odd), 0.3, s));
  }
}

// Two bodies a quarter of a spacing in one another, as drawn by eye, are not thrown apart.
TEST_P(OddBodies, ThoseALittleInOneAnotherPartGently) {
  const std::string block = "type = \"box\"\nsize = [0.08, 0.08, 0.08]\n";
  for (const Matter& matter : {kMatter[0], kMatter[1], kMatter[3], kMatter[4]}) {
    SCOPED_TRACE(matter.name);
    const Scene odd = scene(matter, body(matter, "one", block, {-0.04 + 0.125 * kSpacing, 0, 0.04}) +
                                        body(matter, "other", block, {0.04 - 0.125 * kSpacing, 0, 0.04}));
    const auto simulation = simulate(odd);
    Snapshot s;
    double fastest = 0;
    for (int k = 1; k <= 20; ++k) {
      ASSERT_TRUE(runs_until(*simulation, 0.01 * k, s));
      fastest = std::max(fastest, simulation->output().health.max_speed);
      for (const BodyOutput& out : simulation->output().bodies) fastest = std::max(fastest, out.state.linear.norm());
    }
    RecordProperty(std::string(matter.name) + "_speed", std::to_string(fastest));
    EXPECT_LT(fastest, 0.25 * std::sqrt(1e5 / 1000)) << "m/s: a quarter of a spacing of strain, let go, in the softest";
  }
}

// The ends of the ranges that the reader takes.
TEST_P(OddBodies, MaterialsAtTheEndsOfTheirRangesStayFinite) {
  const std::string block = "type = \"box\"\nsize = [0.08, 0.08, 0.08]\n";
  for (const char* keys :
       {"young_modulus = 1e5\npoisson_ratio = 0.495\n", "young_modulus = 1e5\npoisson_ratio = -0.9\n",
        "young_modulus = 1e-6\n", "young_modulus = 1e8\n", "young_modulus = 1e5\ndamping = 1e3\n"}) {
    SCOPED_TRACE(keys);
    const Matter matter{"extreme", "elastic", keys, 0, true};
    Snapshot s;
    EXPECT_TRUE(runs_until(*simulate(scene(matter, body(matter, "odd", block, {0, 0, 0.05}))), 0.05, s));
  }
}

// At absolute zero, cooled as hard as a scene may, nothing gets colder than that, or warmer than the warmest.
TEST_P(OddBodies, NothingIsColderThanAbsoluteZero) {
  const std::string block = "type = \"box\"\nsize = [0.08, 0.08, 0.08]\n";
  Matter matter = kMatter[4];
  const std::string frozen = body(matter, "odd", block, {0, 0, 0.04});
  const std::string at_zero = std::string(frozen).replace(frozen.find("temperature = "), 21, "temperature = 0.00000");
  Snapshot s;
  const auto simulation =
      simulate(scene(matter, at_zero, "[heat]\nloss_to_air = 1e4\nair_temperature = 0\nrate_hz = 1000\n"));
  for (int k = 1; k <= 10; ++k) {
    ASSERT_TRUE(runs_until(*simulation, 0.02 * k, s));
    for (const float T : s.temperature) ASSERT_TRUE(T >= -1e-3 && T <= 260.001) << T << " K";
  }
  EXPECT_GT(*std::max_element(s.temperature.begin() + 432, s.temperature.end()), 0) << "warmed by the floor";
}

INSTANTIATE_TEST_SUITE_P(Methods, OddBodies, ::testing::Values(Method::paper, Method::accurate),
                         [](const auto& param) { return to_string(param.param); });

}  // namespace
}  // namespace palp::test::degenerate_bodies_test
