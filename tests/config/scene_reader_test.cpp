// Tests what the strict scene reader takes; scene_faults_test.cpp tests what it refuses.
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <set>
#include <sstream>

#include "tests/config/spoilt_scene.h"
#include "tests/support/seed.h"

namespace palp::test::scene_reader_test {
namespace {

TEST(SceneReader, TakesEveryKey) {
  const SceneConfig s = read(kScene);
  EXPECT_EQ(s.path, "a/all.toml");
  EXPECT_EQ(s.name, "all");
  EXPECT_EQ(s.description, "every key");
  EXPECT_EQ(s.method, Method::accurate);
  EXPECT_EQ(s.accuracy, Accuracy::fast);
  EXPECT_EQ(s.gravity, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(s.body_force, Eigen::Vector3d(0.5, 0, 0));
  EXPECT_EQ(s.gravity_ramp, 0.5);
  EXPECT_EQ(s.rate_hz, 1000);
  EXPECT_EQ(s.duration, 2);
  EXPECT_EQ(s.domain_min, Eigen::Vector3d(-1, -1, -1));
  EXPECT_EQ(s.domain_max, Eigen::Vector3d(1, 1, 1));
  EXPECT_EQ(s.periodic, (std::array<bool, 3>{true, false, false}));
  EXPECT_EQ(s.numerics.spacing, 0.1);
  EXPECT_EQ(s.numerics.support_over_spacing, 2.5);
  EXPECT_EQ(s.numerics.sound_speed, 40);
  EXPECT_EQ(s.numerics.max_speed, 2);
  EXPECT_EQ(s.numerics.artificial_viscosity, 0.1);
  EXPECT_EQ(s.numerics.density_diffusion, 0.1);
  EXPECT_EQ(s.numerics.tension, false);
  EXPECT_EQ(s.numerics.sub_steps, 4);
  EXPECT_EQ(s.numerics.safety, 0.4);
  EXPECT_EQ(s.stream.particle_rate_hz, 30);
  EXPECT_EQ(s.stream.scalar, ScalarField::density);
  EXPECT_EQ(s.heat.loss_to_air, 10);
  EXPECT_EQ(s.heat.air_temperature, 290);
  EXPECT_EQ(s.heat.rate_hz, 25);
}

TEST(SceneReader, TakesEveryKeyOfTheTablesThatMayRepeat) {
  const SceneConfig s = read(kScene);
  ASSERT_EQ(s.materials.size(), 1u);
  EXPECT_EQ(s.materials[0].density, 1000);
  EXPECT_EQ(s.materials[0].color, (std::array<float, 3>{16 / 255.f, 32 / 255.f, 48 / 255.f}));
  EXPECT_EQ(s.materials[0].where, "a/all.toml:28");
  ASSERT_EQ(s.bodies.size(), 2u);
  const BodyConfig& stick = s.bodies[1];
  EXPECT_EQ(stick.type, BodyKind::rigid);
  EXPECT_EQ(stick.where, "a/all.toml:41");
  EXPECT_TRUE((stick.orientation * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
  EXPECT_EQ(stick.angular_velocity, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(stick.temperature, 310);
  ASSERT_TRUE(stick.color);
  ASSERT_EQ(stick.shapes.size(), 2u);
  EXPECT_EQ(stick.shapes[0].type, ShapeType::cylinder);
  EXPECT_EQ(stick.shapes[0].height, 0.5);
  EXPECT_EQ(stick.shapes[1].file, "a/parts/spoon.obj");
  EXPECT_EQ(stick.shapes[1].scale, 0.001);
  EXPECT_TRUE(stick.shapes[1].subtract);
  ASSERT_EQ(s.proxies.size(), 1u);
  EXPECT_EQ(s.proxies[0].device, 1u);
  EXPECT_EQ(s.proxies[0].coupling_limit.angular_damping, 4);
  ASSERT_EQ(s.probes.size(), 3u);
  ASSERT_EQ(s.probes[0].points.size(), 3u);
  EXPECT_EQ(s.probes[0].points[1], Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(s.probes[1].axis, 1);
  EXPECT_FALSE(s.probes[1].front_max);
  ASSERT_EQ(s.heat_zones.size(), 1u);
  EXPECT_EQ(s.heat_zones[0].body, "stick");
  EXPECT_EQ(s.heat_zones[0].size, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_NEAR(s.heat_zones[0].orientation.angularDistance(Eigen::Quaterniond::Identity()), EIGEN_PI / 4, 1e-9);
  EXPECT_EQ(s.heat_zones[0].power, 500);
  EXPECT_FALSE(s.heat_zones[0].temperature);
  EXPECT_EQ(s.heat_zones[0].end, 2);
}

TEST(SceneReader, TakesASupportForThoseLevelsThatHaveOne) {
  const std::string levels = "support_over_spacing = {fast = 3, accurate = 2.6}";
  const std::string scene = replaced(kScene, "support_over_spacing = 2.5", levels);
  EXPECT_EQ(read(scene).numerics.support_over_spacing, 3);
  SceneOverrides overrides;
  overrides.accuracy = Accuracy::accurate;
  EXPECT_EQ(read(scene, overrides).numerics.support_over_spacing, 2.6);
  overrides.accuracy = Accuracy::balanced;
  EXPECT_FALSE(read(scene, overrides).numerics.support_over_spacing);
  overrides.settings = {"numerics.support_over_spacing=2.2"};
  EXPECT_EQ(read(scene, overrides).numerics.support_over_spacing, 2.2);
}

TEST(SceneReader, TakesWhatTouches) {
  const std::string rough = "density = 1000\nfriction = 0.6\nkinetic_friction = 0.4\nrestitution = 0.5";
  const SceneConfig given = read(replaced(kScene, "density = 1000", rough));
  EXPECT_EQ(given.materials[0].friction, 0.6);
  EXPECT_EQ(given.materials[0].kinetic_friction, 0.4);
  EXPECT_EQ(given.materials[0].restitution, 0.5);
  const SceneConfig smooth = read(replaced(kScene, "density = 1000", "density = 1000\nfriction = 0.1"));
  EXPECT_EQ(smooth.materials[0].kinetic_friction, 0.1);
}

TEST(SceneReader, TakesWhatMelts) {
  const std::string melts =
      "conductivity = 2\nheat_capacity = 2100\nmelting_temperature = 273.15\nlatent_heat = 3.3e5\ncolor = \"#102030\"";
  SceneConfig s = read(replaced(kScene, "color = \"#102030\"", melts));
  EXPECT_EQ(s.materials[0].conductivity, 2);
  EXPECT_EQ(s.materials[0].heat_capacity, 2100);
  EXPECT_EQ(s.materials[0].melting_temperature, 273.15);
  EXPECT_EQ(s.materials[0].latent_heat, 3.3e5);
  EXPECT_FALSE(s.bodies[1].hold_temperature);
  s = read(replaced(kScene, "temperature = 310", "temperature = 310\nhold_temperature = true"));
  EXPECT_TRUE(s.bodies[1].hold_temperature);
  s = read(replaced(kScene, "power = 500", "temperature = 500"));
  EXPECT_EQ(s.heat_zones[0].temperature, 500);
}

TEST(SceneReader, TakesWhatBecomesRigid) {
  const std::string wax =
      "young_modulus = 1e5\nheat_capacity = 2100\nmelting_temperature = 330\nlatent_heat = 2e5\nrigid_below = 320\n"
      "cooking_temperature = 350\nrigid_when_set = true\ncolor = \"#102030\"";
  const SceneConfig s = read(replaced(kScene, "color = \"#102030\"", wax));
  EXPECT_EQ(s.materials[0].rigid_below, 320);
  EXPECT_TRUE(s.materials[0].rigid_when_set);
}

TEST(SceneReader, TakesWhatYieldsAndTears) {
  const std::string dough =
      "young_modulus = 5e4\nyield_stress = 1500\nhardening = 1000\ntear_strain = 2\ncolor = \"#102030\"";
  const SceneConfig s = read(replaced(kScene, "color = \"#102030\"", dough));
  EXPECT_EQ(s.materials[0].yield_stress, 1500);
  EXPECT_EQ(s.materials[0].hardening, 1000);
  EXPECT_EQ(s.materials[0].tear_strain, 2);
}

TEST(SceneReader, HeatNeedsTemperatures) {
  const std::string cold = replaced(replaced(kScene, "temperature = 300", ""), "temperature = 310", "");
  const std::vector<std::string> faults = faults_of(cold);
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_NE(faults[0].find("84: heat: loss_to_air is given, but no body has a temperature"), std::string::npos);
  EXPECT_NE(faults[1].find("there is a heat_zone, but no body has a temperature"), std::string::npos);
}

TEST(SceneReader, OverridesWinAndChangeTheHash) {
  const SceneConfig plain = read(kScene);
  SceneOverrides overrides;
  overrides.accuracy = Accuracy::accurate;
  const SceneConfig fine = read(kScene, overrides);
  EXPECT_EQ(fine.numerics.spacing, 0.02);
  EXPECT_NE(fine.hash, plain.hash);
  overrides.spacing = 0.25;
  overrides.method = Method::paper;
  const SceneConfig coarse = read(replaced(kScene, "true, false, false", "false, false, false"), overrides);
  EXPECT_EQ(coarse.numerics.spacing, 0.25);
  EXPECT_EQ(coarse.method, Method::paper);
  EXPECT_EQ(plain.hash, read(kScene).hash);
  EXPECT_NE(plain.hash, read(kScene + "\n").hash);
  overrides.spacing = std::nan("");
  EXPECT_EQ(faults_of(kScene, overrides).size(), 1u);
}

TEST(SceneReader, SettingsWinOverTheFileAndChangeTheHash) {
  const SceneConfig plain = read(kScene);
  SceneOverrides overrides;
  overrides.settings = {"numerics.safety=0.9",
                        "numerics.safety=0.3",
                        "numerics.elastic_solver=explicit",
                        "numerics.tension=true",
                        "numerics.skin_over_spacing=0.3",
                        "scene.rate_hz=500",
                        "scene.gravity=[0, 0, -1]",
                        "scene.name=\"by hand\"",
                        "numerics.spacing.fast=0.2",
                        "heat.rate_hz=50",
                        "stream.scalar=temperature",
                        "domain.periodic=[false, false, false]"};
  const SceneConfig set = read(kScene, overrides);
  EXPECT_EQ(set.numerics.safety, 0.3);
  EXPECT_EQ(set.numerics.elastic_solver, ElasticSolver::explicit_);
  EXPECT_EQ(set.numerics.tension, true);
  EXPECT_EQ(set.numerics.skin_over_spacing, 0.3);
  EXPECT_EQ(set.rate_hz, 500);
  EXPECT_EQ(set.gravity, Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ(set.name, "by hand");
  EXPECT_EQ(set.numerics.spacing, 0.2);
  EXPECT_EQ(set.heat.rate_hz, 50);
  EXPECT_EQ(set.stream.scalar, ScalarField::temperature);
  EXPECT_EQ(set.numerics.max_speed, plain.numerics.max_speed);
  EXPECT_NE(set.hash, plain.hash);
  SceneOverrides other = overrides;
  other.settings[1] = "numerics.safety=0.31";
  EXPECT_NE(read(kScene, other).hash, set.hash);
  other.settings = {"numerics.elastic_rounds=20"};
  EXPECT_EQ(read(kScene, other).numerics.elastic_rounds, 20);
  other.settings = {"numerics.fluid_interval=3"};
  EXPECT_EQ(read(kScene, other).numerics.fluid_interval, 3);
  other.settings = {"numerics.spacing=0.15"};
  EXPECT_EQ(read(kScene, other).numerics.spacing, 0.15);
  other.spacing = 0.25;
  EXPECT_EQ(read(kScene, other).numerics.spacing, 0.25);
}

TEST(SceneReader, ASettingMakesATableThatTheFileLacks) {
  const std::string bare =
      replaced(kScene, "[stream]\nparticle_rate_hz = 30                   # 26\nscalar = \"density\"\n", "");
  SceneOverrides overrides;
  overrides.settings = {"stream.particle_rate_hz=7"};
  EXPECT_EQ(read(bare, overrides).stream.particle_rate_hz, 7);
}

// Returns the keys that README.md documents: its headings name tables, its rows begin with a key.
std::set<std::string> documented_keys() {
  std::ifstream in(PALP_SOURCE_DIR "/config/scenes/README.md");
  std::set<std::string> keys;
  std::vector<std::string> tables;
  std::string line;
  while (std::getline(in, line)) {
    if (line.rfind("### ", 0) == 0) {
      tables.clear();
      // names in the innermost brackets
      for (std::size_t end = line.find(']'); end != std::string::npos; end = line.find(']', end + 1)) {
        const std::size_t begin = line.rfind('[', end) + 1;
        if (line[end - 1] != ']') tables.push_back(line.substr(begin, end - begin));
      }
      keys.insert(tables.begin(), tables.end());
    } else if (line.rfind("| `", 0) == 0) {
      const std::string key = line.substr(3, line.find('`', 3) - 3);
      for (const std::string& table : tables) keys.insert(table + "." + key);
    }
  }
  return keys;
}

TEST(SceneReader, ReadmeDocumentsExactlyTheKeysThatAreRead) {
  // looks are names elsewhere
  std::string text = replaced(kScene, "color = \"#102030\"",
                              "color = \"#102030\"\nlook = {base = \"oil\"}\nchanged_look = {base = \"oil\"}\n"
                              "cooking_temperature = 345\nyoung_modulus = 1e4\nheat_capacity = 3000");
  text = replaced(text, "color = \"#ffffff\"", "color = \"#ffffff\"\nlook = {base = \"wood\"}");
  TomlFile file = TomlFile::parse(text, "all.toml");
  read_scene(file, "all.toml", {});
  EXPECT_EQ(file.asked(), documented_keys());
}

// Whatever is done to a scene file, it is read or refused with messages, never worse.
TEST(SceneReader, FuzzedFilesAreReadOrRefused) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  using namespace std::string_literals;
  const std::string bytes = "[]{}=.,\"'#\n\\-+e0159truefalsenaninf \t\xff\x00\xc3"s;
  int refused = 0;
  for (int round = 0; round < 1500; ++round) {
    std::string text = kScene;
    const int kind = static_cast<int>(random() % 3);
    if (kind == 0) text.resize(random() % text.size());
    for (int edit = 0; kind > 0 && edit < 1 + static_cast<int>(random() % 6); ++edit) {
      const std::size_t at = random() % text.size();
      if (kind == 1) text[at] = bytes[random() % bytes.size()];
      if (kind == 2) text.erase(at, 1 + random() % 20);
      if (text.empty()) text.assign(1, '\n');
    }
    const std::vector<std::string> faults = faults_of(text);
    refused += faults.empty() ? 0 : 1;
    for (const std::string& fault : faults) EXPECT_EQ(fault.rfind("a/all.toml", 0), 0u) << fault;
  }
  EXPECT_GT(refused, 700);
}

}  // namespace
}  // namespace palp::test::scene_reader_test
