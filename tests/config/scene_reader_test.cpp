// The strict scene reader: what it takes, and one message for each way to be wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <set>
#include <sstream>

#include "config/error.h"
#include "config/scene_reader.h"
#include "tests/support/seed.h"

namespace palp {
namespace {

// Uses every table and key there is. Lines are numbered in the comments, as the expected messages name them.
const std::string kScene = R"([scene]
name = "all"                            # 2
description = "every key"
method = "accurate"                     # 4
accuracy = "fast"
gravity = [0, 0, -9.81]                 # 6
body_force = [0.5, 0, 0]
gravity_ramp = 0.5                      # 8
rate_hz = 1000
duration = 2                            # 10
[domain]
min = [-1, -1, -1]                      # 12
max = [1, 1, 1]
periodic = [true, false, false]         # 14
[numerics]
spacing = {fast = 0.1, balanced = 0.05, accurate = 0.02}   # 16
support_over_spacing = 2.5
sound_speed = 40                        # 18
max_speed = 2
artificial_viscosity = 0.1              # 20
density_diffusion = 0.1
tension = false                         # 22
sub_steps = 4
safety = 0.4                            # 24
[stream]
particle_rate_hz = 30                   # 26
scalar = "density"
[[material]]                            # 28
name = "water"
density = 1000                          # 30
viscosity = 1e-3
color = "#102030"                       # 32
[[body]]
name = "pool"                           # 34
type = "fluid"
material = "water"                      # 36
temperature = 300
[[body.shape]]                          # 38
type = "box"
size = [1, 1, 0.5]                      # 40
[[body]]
name = "stick"                          # 42
type = "rigid"
material = "water"                      # 44
position = [0, 0, 0.8]
rotation_deg = {axis = [0, 0, 2], angle = 90}   # 46
velocity = [1, 0, 0]
angular_velocity = [0, 0, 1]            # 48
temperature = 310
color = "#ffffff"                       # 50
[[body.shape]]
type = "cylinder"                       # 52
radius = 0.1
height = 0.5                            # 54
orientation = [0, 0, 0, 1]
[[body.shape]]                          # 56
type = "mesh"
file = "parts/spoon.obj"                # 58
scale = 0.001
position = [0, 0, -0.1]                 # 60
rotation_deg = {axis = [1, 0, 0], angle = -30}
subtract = true                         # 62
[[proxy]]
device = 1                              # 64
body = "stick"
handle = [0, 0, 0.2]                    # 66
coupling_limit = {stiffness = 1, damping = 2, angular_stiffness = 3, angular_damping = 4}
[[probe]]                               # 68
name = "column"
quantity = "pressure"                   # 70
line = {from = [0, 0, -0.5], to = [0, 0, 0.5], count = 3}
rate_hz = 50                            # 72
[[probe]]
name = "front"                          # 74
quantity = "front"
body = "pool"                           # 76
axis = "y"
side = "min"                            # 78
[[probe]]
name = "spot"                           # 80
quantity = "velocity"
point = [0.5, 0, 0]                     # 82
[heat]
loss_to_air = 10                        # 84
air_temperature = 290
rate_hz = 25                            # 86
[[heat_zone]]
name = "flame"                          # 88
body = "stick"
position = [0, 0, -0.2]                 # 90
rotation_deg = {axis = [0, 0, 1], angle = 45}
size = [0.1, 0.2, 0.3]                  # 92
power = 500
start = 1                               # 94
end = 2
)";

SceneConfig read(const std::string& text, const SceneOverrides& overrides = {}) {
  TomlFile file = TomlFile::parse(text, "a/all.toml");
  SceneConfig scene = read_scene(file, "a/all.toml", overrides);
  file.finish();
  return scene;
}

std::vector<std::string> faults_of(const std::string& text, const SceneOverrides& overrides = {}) {
  try {
    read(text, overrides);
  } catch (const ConfigError& error) {
    return error.faults();
  }
  return {};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

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
  EXPECT_EQ(s.heat.loss_to_air, 10);
  EXPECT_EQ(s.heat.air_temperature, 290);
  EXPECT_EQ(s.heat.rate_hz, 25);
  ASSERT_EQ(s.heat_zones.size(), 1u);
  EXPECT_EQ(s.heat_zones[0].body, "stick");
  EXPECT_EQ(s.heat_zones[0].size, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_NEAR(s.heat_zones[0].orientation.angularDistance(Eigen::Quaterniond::Identity()), EIGEN_PI / 4, 1e-9);
  EXPECT_EQ(s.heat_zones[0].power, 500);
  EXPECT_FALSE(s.heat_zones[0].temperature);
  EXPECT_EQ(s.heat_zones[0].end, 2);
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

struct BadRow {
  const char *from, *to;
  const char* fault;  // the only fault, without the path
};

const BadRow kBad[] = {
    {"density = 1000", "density = -5",
     "30: material 'water': density is -5, expected a number in kg/m^3 from 1e-06 to 1000000"},
    {"density = 1000", "density = nan",
     "30: material 'water': density is nan, expected a number in kg/m^3 from 1e-06 to 1000000"},
    {"density = 1000", "density = 1e-30", "30: material 'water': density is 1e-30, expected"},
    {"density = 1000", "density = 0", "30: material 'water': density is 0, expected"},
    {"density = 1000", "density = inf", "30: material 'water': density is inf, expected"},
    {"density = 1000", "density = \"heavy\"", "30: material 'water': density is \"heavy\", expected a number"},
    {"density = 1000", "densty = 1000", "28: material 'water': density is missing, expected a number in kg/m^3"},
    {"gravity_ramp = 0.5", "gravity_rmap = 0.5",
     "8: unknown key 'gravity_rmap' in [scene], did you mean 'gravity_ramp'?"},
    {"safety = 0.4", "frobnicate = 0.4",
     "24: unknown key 'frobnicate' in [numerics], expected one of: artificial_viscosity,"},
    {"radius = 0.1", "radius = 0.1\nsize = [1,1,1]", "54: body 'stick': shape 1: size does not apply to a cylinder"},
    {"angle = -30", "angel = -30", "61: unknown key 'angel' in [body.shape.rotation_deg], did you mean 'angle'?"},
    {"[stream]", "[streem]", "25: unknown key 'streem', did you mean 'stream'?"},
    {"gravity = [0, 0, -9.81]", "gravity = [0, -9.81]",
     "6: [scene]: gravity is an array of 2, expected an array of 3 numbers"},
    {"gravity = [0, 0, -9.81]", "gravity = [0, 0, inf]", "6: [scene]: gravity[2] is inf, expected a number in m/s^2"},
    {"gravity = [0, 0, -9.81]", "gravity = 9.81", "6: [scene]: gravity is 9.81, expected an array of 3 numbers"},
    {"method = \"accurate\"", "method = \"papr\"",
     "4: [scene]: method is \"papr\", expected one of: paper, accurate; did you mean 'paper'?"},
    {"method = \"accurate\"", "method = true", "4: [scene]: method is true, expected one of: paper, accurate"},
    {"rate_hz = 1000", "rate_hz = 0", "9: [scene]: rate_hz is 0, expected a number in Hz from 1 to 1000000"},
    {"duration = 2", "duration = 0.0", "10: [scene]: duration is 0, expected a number in s above 0"},
    {"max = [1, 1, 1]", "max = [1, -1, 1]", "13: domain: max is -1 on axis y, expected more than min, which is -1"},
    {"min = [-1, -1, -1]", "", "11: domain: min is missing, expected an array of 3 numbers"},
    {"min = [-1, -1, -1]", "min = [0.9, -1, -1]",
     "14: domain: axis x is periodic and 0.1 m long, expected at least 0.75 m (3 support radii)"},
    {"max = [1, 1, 1]", "max = [1, 1, 1e6]",
     "13: domain: axis z is 1e+06 m long, expected at most 100000 m (1e+06 spacings)"},
    {"max = [1, 1, 1]", "max = [1, 1, -0.95]",
     "13: domain: axis z is 0.05 m long, expected at least the particle spacing 0.1 m"},
    {"[true, false, false]", "[true, false]",
     "14: domain: periodic is an array of 2, expected an array of 3 of true or false"},
    {"[true, false, false]", "[true, 0, false]",
     "14: domain: periodic is an array of 3, expected an array of 3 of true or false"},
    {"spacing = {fast = 0.1, balanced = 0.05, accurate = 0.02}", "",
     "15: numerics: spacing is missing, expected a number in m from 1e-07 to 1000"},
    {"fast = 0.1, ", "",
     "16: numerics: [numerics.spacing]: fast is missing, expected a number in m from 1e-07 to 1000"},
    {"balanced = 0.05", "balanced = 0.5",
     "16: numerics: [numerics.spacing]: spacing 0.5 of 'balanced' is coarser than 0.1 of 'fast'"},
    {"{fast = 0.1, balanced = 0.05, accurate = 0.02}", "\"fine\"",
     "16: numerics: spacing is \"fine\", expected a number in m from 1e-07 to 1000"},
    {"support_over_spacing = 2.5", "support_over_spacing = 1.5",
     "17: numerics: support_over_spacing is 1.5, expected a number from 1.8 to 4"},
    {"sound_speed = 40", "sound_speed = 1", "18: numerics: sound_speed is 1, expected more than max_speed, which is 2"},
    {"sub_steps = 4", "sub_steps = 2.5", "23: numerics: sub_steps is 2.5, expected a whole number from 1 to 100000"},
    {"sub_steps = 4", "sub_steps = 0", "23: numerics: sub_steps is 0, expected a whole number"},
    {"tension = false", "tension = 0", "22: numerics: tension is 0, expected true or false"},
    {"scalar = \"density\"", "scalar = \"colour\"",
     "27: stream: scalar is \"colour\", expected one of: none, speed, density, pressure, temperature"},
    {"color = \"#102030\"", "color = \"red\"",
     "32: material 'water': color is \"red\", expected a colour as \"#rrggbb\""},
    {"material = \"water\"", "material = \"watr\"",
     "36: body 'pool': material 'watr' is not declared, expected the name of a [[material]]; did you mean 'water'?"},
    {"name = \"stick\"", "name = \"pool\"",
     "42: body 'pool': name is taken by another body, expected a name of its own"},
    {"name = \"pool\"", "name = \"po\\tol\"", "34: body 'po\tol': name is \"po\tol\", expected at most 64"},
    {"type = \"fluid\"", "type = \"liquid\"",
     "35: body 'pool': type is \"liquid\", expected one of: fluid, rigid, static"},
    {"temperature = 300", "temperature = -3",
     "37: body 'pool': temperature is -3, expected a number in K from 0 to 100000"},
    {"size = [1, 1, 0.5]", "size = [1, 0, 0.5]",
     "40: body 'pool': shape 1: size[1] is 0, expected a number in m above 0"},
    {"size = [1, 1, 0.5]", "", "38: body 'pool': shape 1: size is missing, expected an array of 3 numbers"},
    {"[[body.shape]]                          # 38\ntype = \"box\"\nsize = [1, 1, 0.5]", "",
     "33: body 'pool': shape is missing, expected at least one shape"},
    {"[[body.shape]]                          # 38", "[body.shape]",
     "38: body 'pool': shape is a table, expected tables, each under a line [[body.shape]]"},
    {"orientation = [0, 0, 0, 1]", "orientation = [0, 0, 0, 0.5]",
     "55: body 'stick': shape 1: orientation has length 0.5, expected a unit quaternion"},
    {"rotation_deg = {axis = [1, 0, 0], angle = -30}", "rotation_deg = {axis = [0, 0, 0], angle = -30}",
     "61: body 'stick': shape 2: [body.shape.rotation_deg]: axis has no length, expected a direction"},
    {"orientation = [0, 0, 0, 1]", "orientation = [0, 0, 0, 1]\nrotation_deg = {axis = [0, 0, 1], angle = 1}",
     "56: body 'stick': shape 1: both orientation and rotation_deg are given"},
    {"file = \"parts/spoon.obj\"", "",
     "56: body 'stick': shape 2: file is missing, expected a text in quotes, not empty"},
    {"type = \"mesh\"", "type = \"sphere\"\nradius = 1", "59: body 'stick': shape 2: file does not apply to a sphere"},
    {"height = 0.5", "height = 0.5\nsubtract = true", "55: body 'stick': shape 1: subtract is true on the first shape"},
    {"velocity = [1, 0, 0]\nangular_velocity", "velocity = [1, 0]\nangular_velocity",
     "47: body 'stick': velocity is an array of 2"},
    {"temperature = 300", "temperature = 300\nangular_velocity = [1, 0, 0]",
     "38: body 'pool': angular_velocity is given, but only a rigid body has one"},
    {"device = 1", "device = 8", "64: proxy 1: device is 8, expected a whole number from 0 to 7"},
    {"body = \"stick\"", "body = \"stik\"",
     "65: proxy 1: body 'stik' is not declared, expected the name of a [[body]]; did you mean 'stick'?"},
    {"body = \"stick\"", "body = \"pool\"", "65: proxy 1: body 'pool' is fluid, expected a rigid body"},
    {"damping = 2,", "damping = -2,",
     "67: proxy 1: [proxy.coupling_limit]: damping is -2, expected a number in N s/m of at least 0"},
    {"name = \"front\"", "name = \"column\"", "74: probe 'column': name is taken by another probe"},
    {"name = \"front\"", "name = \"../front\"",
     "74: probe '../front': name is \"../front\", expected at most 64 letters, digits, - and _ (it names a file)"},
    {"count = 3", "count = 1", "71: probe 'column': [probe.line]: count is 1, expected a whole number from 2 to 10000"},
    {"to = [0, 0, 0.5]", "to = [0, 0, 5]",
     "71: probe 'column': (0, 0, 2.25) is outside the domain, expected a point inside it"},
    {"rate_hz = 50", "rate_hz = 5000",
     "72: probe 'column': rate_hz is 5000, expected at most the scene's rate_hz, which is 1000"},
    {"point = [0.5, 0, 0]", "",
     "79: probe 'spot': point is missing, expected a point or a line where to measure the velocity"},
    {"point = [0.5, 0, 0]", "point = [0.5, 0, 0]\nbody = \"pool\"",
     "83: probe 'spot': body does not apply to a probe of velocity"},
    {"body = \"pool\"", "body = \"stick\"",
     "76: probe 'front': body 'stick' does not deform, expected a fluid or elastic body"},
    {"quantity = \"front\"", "quantity = \"body\"\n#",
     "77: probe 'front': body 'pool' is a fluid, expected a rigid or static body"},
    {"axis = \"y\"", "axis = \"w\"", "77: probe 'front': axis is \"w\", expected one of: x, y, z"},
    {"density = 1000", "density = 1000\nfriction = -0.1",
     "31: material 'water': friction is -0.1, expected a number from 0 to 10"},
    {"density = 1000", "density = 1000\nfriction = 0.2\nkinetic_friction = 0.3",
     "32: material 'water': kinetic_friction is 0.3, expected at most friction, which is 0.2"},
    {"density = 1000", "density = 1000\nrestitution = 1.1",
     "31: material 'water': restitution is 1.1, expected a number from 0 to 1"},
    {"density = 1000", "density = 1000\nconductivity = -1",
     "31: material 'water': conductivity is -1, expected a number in W/(m K) from 0 to 1000000"},
    {"density = 1000", "density = 1000\nconductivity = 1",
     "31: material 'water': conductivity is given without heat_capacity, expected one in J/(kg K)"},
    {"density = 1000", "density = 1000\nheat_capacity = 0",
     "31: material 'water': heat_capacity is 0, expected a number in J/(kg K) above 0"},
    {"density = 1000", "density = 1000\nheat_capacity = 1\nmelting_temperature = 300",
     "32: material 'water': melting_temperature is given without latent_heat, expected both or none"},
    {"density = 1000", "density = 1000\nlatent_heat = 300",
     "31: material 'water': latent_heat is given without melting_temperature, expected both or none"},
    {"density = 1000", "density = 1000\nrigid_below = 300",
     "31: material 'water': rigid_below is given, but the material does not change state; give it a young_modulus, and "
     "a melting_temperature or a cooking_temperature"},
    {"density = 1000",
     "density = 1000\nyoung_modulus = 1e5\nheat_capacity = 1\nmelting_temperature = 300\nlatent_heat = 1\n"
     "rigid_below = 301",
     "35: material 'water': rigid_below is 301, expected at most the melting_temperature, which is 300"},
    {"density = 1000", "density = 1000\nrigid_when_set = true",
     "31: material 'water': rigid_when_set is true, but nothing sets; give a cooking_temperature in K"},
    {"density = 1000", "density = 1000\nyield_stress = 100",
     "31: material 'water': yield_stress is given without young_modulus, expected one in Pa"},
    {"density = 1000", "density = 1000\ntear_strain = 0.1",
     "31: material 'water': tear_strain is given without young_modulus, expected one in Pa"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\nhardening = 100",
     "32: material 'water': hardening is given without yield_stress, expected both or only yield_stress"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\nyield_stress = 0",
     "32: material 'water': yield_stress is 0, expected a number in Pa above 0"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\npoisson_ratio = 0.5",
     "32: material 'water': poisson_ratio is 0.5, expected a number from -0.9 to 0.495"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\npoisson_ratio = 0.6",
     "32: material 'water': poisson_ratio is 0.6, expected a number from -0.9 to 0.495"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\npoisson_ratio = -1",
     "32: material 'water': poisson_ratio is -1, expected a number from -0.9 to 0.495"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\npoisson_ratio = nan",
     "32: material 'water': poisson_ratio is nan, expected a number from -0.9 to 0.495"},
    {"density = 1000", "density = 1000\nyoung_modulus = 0",
     "31: material 'water': young_modulus is 0, expected a number in Pa from 1e-06 to 1000000000000"},
    {"density = 1000", "density = 1000\nyoung_modulus = -1e5",
     "31: material 'water': young_modulus is -100000, expected a number in Pa from 1e-06 to 1000000000000"},
    {"density = 1000", "density = 1000\nyoung_modulus = nan",
     "31: material 'water': young_modulus is nan, expected a number in Pa from 1e-06 to 1000000000000"},
    {"density = 1000", "density = 1000\nyoung_modulus = inf",
     "31: material 'water': young_modulus is inf, expected a number in Pa from 1e-06 to 1000000000000"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\ndamping = -1",
     "32: material 'water': damping is -1, expected a number in Pa s from 0 to 1000000000"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\ntear_strain = 0",
     "32: material 'water': tear_strain is 0, expected a number above 0 and at most 1000"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\ntear_strain = -0.5",
     "32: material 'water': tear_strain is -0.5, expected a number above 0 and at most 1000"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\nyield_stress = -100",
     "32: material 'water': yield_stress is -100, expected a number in Pa above 0"},
    {"density = 1000", "density = 1000\nsurface_tension = -0.07",
     "31: material 'water': surface_tension is -0.07, expected a number in N/m from 0 to 1000000"},
    {"density = 1000", "density = 1000\nadhesion = -1",
     "31: material 'water': adhesion is -1, expected a number in N/m from 0 to 1000000"},
    {"viscosity = 1e-3", "viscosity = -1", "31: material 'water': viscosity is -1, expected a number in Pa s from 0"},
    {"density = 1000", "density = 1000\nheat_capacity = 1\nmelting_temperature = -5\nlatent_heat = 1",
     "32: material 'water': melting_temperature is -5, expected a number in K from 0 to 100000"},
    {"density = 1000", "density = 1000\nyoung_modulus = 1e5\nheat_capacity = 1\ncooking_temperature = -1",
     "33: material 'water': cooking_temperature is -1, expected a number in K from 0 to 100000"},
    {"power = 500", "temperature = -1", "93: heat_zone 'flame': temperature is -1, expected a number in K from 0 to"},
    {"power = 500", "power = -500", "93: heat_zone 'flame': power is -500, expected a number in W from 0 to"},
    {"max = [1, 1, 1]", "max = [1, 1, 100001]", "13: domain: axis z is 100002 m long, expected at most 100000 m"},
    {"min = [-1, -1, -1]                      # 12\nmax = [1, 1, 1]", "min = [-1, -1, 99999]\nmax = [1, 1, 100001]",
     "13: domain: axis z reaches 100001 m from the origin, expected at most 100000 m (1e+06 spacings)"},
    {"min = [-1, -1, -1]                      # 12\nmax = [1, 1, 1]", "min = [-1, -100001, -1]\nmax = [1, -99999, 1]",
     "12: domain: axis y reaches 100001 m from the origin, expected at most 100000 m (1e+06 spacings)"},
    {"temperature = 310", "hold_temperature = true",
     "49: body 'stick': hold_temperature is true, but the body has no temperature; give it one"},
    {"loss_to_air = 10 ", "loss_to_air = -1", "84: heat: loss_to_air is -1, expected a number in W/(m^2 K) from 0"},
    {"loss_to_air = 10 ", "loss_to_air = 0",
     "85: heat: air_temperature is given, but loss_to_air is 0; give a coefficient in W/(m^2 K)"},
    {"air_temperature = 290", "air_temperature = -1",
     "85: heat: air_temperature is -1, expected a number in K from 0 to 100000"},
    {"power = 500", "", "87: heat_zone 'flame': neither power nor temperature is given, expected one of them"},
    {"power = 500", "power = 500\ntemperature = 400",
     "93: heat_zone 'flame': both power and temperature are given, expected one of them"},
    {"end = 2\n", "end = 0.5\n", "95: heat_zone 'flame': end is 0.5, expected more than start, which is 1"},
    {"body = \"stick\"\nposition = [0, 0, -0.2]", "body = \"pool\"\nposition = [0, 0, -0.2]",
     "89: heat_zone 'flame': body 'pool' has no frame to move with, expected a rigid or static body"},
    {"size = [0.1, 0.2, 0.3]", "", "87: heat_zone 'flame': size is missing, expected an array of 3 numbers"},
    {"[scene]\n", "[scene\n", "1: not valid TOML"},
    {"rate_hz = 1000", "rate_hz = 1000\nrate_hz = 1000", "10: not valid TOML"},
    {"duration = 2", "duration =", "10: not valid TOML"},
};

TEST(SceneReader, EachFaultHasItsMessageAndLine) {
  for (const BadRow& row : kBad) {
    const std::vector<std::string> faults = faults_of(replaced(kScene, row.from, row.to));
    ASSERT_FALSE(faults.empty()) << row.to;
    const std::string expected = std::string("a/all.toml:") + row.fault;
    const bool found = std::any_of(faults.begin(), faults.end(),
                                   [&](const std::string& fault) { return fault.rfind(expected, 0) == 0; });
    std::string all;
    for (const std::string& fault : faults) all.append(fault).append("\n");
    EXPECT_TRUE(found) << "expected " << expected << "\ngot\n" << all;
    EXPECT_LE(faults.size(), 3u) << all;
  }
}

TEST(SceneReader, ReportsAllFaultsInOrderOfLines) {
  std::string text = replaced(kScene, "density = 1000", "density = -5");
  text = replaced(text, "rate_hz = 1000", "rate_hz = \"fast\"");
  text = replaced(text, "safety = 0.4", "safty = 0.4");
  text = replaced(text, "body = \"stick\"", "body = \"stock\"");
  const std::vector<std::string> faults = faults_of(text);
  ASSERT_EQ(faults.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const char* lines[] = {"9", "24", "30", "65"};
    EXPECT_EQ(faults[i].rfind(std::string("a/all.toml:") + lines[i] + ":", 0), 0u) << faults[i];
  }
}

TEST(SceneReader, EmptyFileNamesWhatIsMissing) {
  const std::vector<std::string> faults = faults_of("");
  EXPECT_EQ(faults.size(), 4u);  // scene, domain, spacing, body
}

TEST(SceneReader, TwoProxiesMayNotShareDeviceOrBody) {
  const std::vector<std::string> faults = faults_of(kScene + "[[proxy]]\ndevice = 1\nbody = \"stick\"\n");
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_NE(faults[0].find("device 1 already drives body 'stick'"), std::string::npos);
  EXPECT_NE(faults[1].find("body 'stick' is already the proxy of device 1"), std::string::npos);
}

TEST(SceneReader, MissingFileAndFolder) {
  EXPECT_THROW(load_scene("/nowhere/scene.toml"), ConfigError);
  EXPECT_THROW(load_scene(PALP_SOURCE_DIR "/config"), ConfigError);
}

// The keys that README.md documents: its headings name tables, its rows begin with a key.
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
  TomlFile file = TomlFile::parse(kScene, "all.toml");
  read_scene(file, "all.toml", {});
  EXPECT_EQ(file.asked(), documented_keys());
}

// Whatever is done to a scene file, it is read or refused with messages, never worse.
TEST(SceneReader, FuzzedFilesAreReadOrRefused) {
  const unsigned seed = test::drawn_seed();
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
}  // namespace palp
