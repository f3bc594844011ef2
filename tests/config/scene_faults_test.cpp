// The faults that the strict scene reader finds: one message for each way to be wrong.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/config/spoilt_scene.h"

namespace palp::test::scene_faults_test {
namespace {

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
    {"duration = 2", "duration = 0.0005",
     "10: [scene]: duration is 0.0005 s, expected at least one haptic step of 0.001 s; make it longer or raise "
     "rate_hz"},
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
    {"support_over_spacing = 2.5", "support_over_spacing = {fast = 2, balanced = 5}",
     "17: numerics: [numerics.support_over_spacing]: balanced is 5, expected a number from 1.8 to 4"},
    {"sound_speed = 40", "sound_speed = 1", "18: numerics: sound_speed is 1, expected more than max_speed, which is 2"},
    {"sub_steps = 4", "sub_steps = 2.5", "23: numerics: sub_steps is 2.5, expected a whole number from 1 to 100000"},
    {"sub_steps = 4", "sub_steps = 0", "23: numerics: sub_steps is 0, expected a whole number"},
    {"tension = false", "fluid_interval = 0",
     "22: numerics: fluid_interval is 0, expected a whole number from 1 to 100"},
    {"tension = false", "elastic_rounds = 0",
     "22: numerics: elastic_rounds is 0, expected a whole number from 1 to 1000"},
    {"sub_steps = 4\n", "elastic_solver = \"explicit\"\nelastic_rounds = 5\n",
     "24: numerics: elastic_rounds is of an implicit solve, but elastic_solver is \"explicit\""},
    {"tension = false", "skin_over_spacing = 0",
     "22: numerics: skin_over_spacing is 0, expected a number from 0.02 to 1"},
    {"tension = false", "tension = 0", "22: numerics: tension is 0, expected true or false"},
    {"scalar = \"density\"", "scalar = \"colour\"",
     "27: stream: scalar is \"colour\", expected one of: none, speed, density, pressure, temperature, "
     "density_error, state"},
    {"color = \"#102030\"", "color = \"red\"",
     "32: material 'water': color is \"red\", expected a colour as \"#rrggbb\""},
    {"color = \"#102030\"", "look = \"watr\"",
     "32: material 'water': look is \"watr\", expected one of: water, juice, oil, honey, syrup, jelly, ice, glass, "
     "milk, "
     "cream, batter, custard, butter, chocolate, dough, paste, crepe, china, stone, wood, plastic, rubber, steel, "
     "iron, "
     "aluminium, "
     "copper; did you mean 'water'?"},
    {"color = \"#102030\"", "changed_look = \"ice\"",
     "28: material 'water' has a changed_look and never changes state, expected a melting_temperature"},
    {"color = \"#102030\"", "look = 5", "32: material 'water': look is 5, expected one of: water, juice"},
    {"color = \"#102030\"", "look = {base = \"oyl\"}",
     "32: material 'water': [material.look]: base is \"oyl\", expected one of: water"},
    {"color = \"#102030\"", "look = {roughness = 2}",
     "32: material 'water': [material.look]: roughness is 2, expected a number from 0 to 1"},
    {"color = \"#102030\"", "look = {refractive_index = 0.9}",
     "32: material 'water': [material.look]: refractive_index is 0.9, expected a number from 1 to 5"},
    {"color = \"#102030\"", "look = {absorption_per_m = [1, 2]}",
     "32: material 'water': [material.look]: absorption_per_m is an array of 2"},
    {"color = \"#102030\"", "look = {scattering_length = -1}",
     "32: material 'water': [material.look]: scattering_length is -1, expected a number in m from 0 to 1000"},
    {"color = \"#102030\"", "look = {gloss = 1}", "32: unknown key 'gloss' in [material.look], expected one of: "},
    {"color = \"#ffffff\"", "look = \"woood\"", "50: body 'stick': look is \"woood\", expected one of: water"},
    {"material = \"water\"", "material = \"watr\"",
     "36: body 'pool': material 'watr' is not declared, expected the name of a [[material]]; did you mean 'water'?"},
    {"name = \"stick\"", "name = \"pool\"",
     "42: body 'pool': name is taken by another body, expected a name of its own"},
    {"name = \"pool\"", "name = \"po\\tol\"", "34: body 'po\\x09ol': name is \"po\\x09ol\", expected at most 64"},
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

TEST(SceneFaults, EachFaultHasItsMessageAndLine) {
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

// A setting is refused as its value in the file would be, and is named instead of a line.
TEST(SceneFaults, EachFaultOfASettingNamesIt) {
  const struct {
    const char *setting, *fault;
  } rows[] = {
      {"numerics.safety=2", "numerics: safety is 2, expected a number from 0.05 to 1"},
      {"numerics.safety=nan", "numerics: safety is nan, expected"},
      {"numerics.safety=much", "numerics: safety is \"much\", expected a number"},
      {"numerics.saftey=0.4", "unknown key 'saftey' in [numerics], did you mean 'safety'?"},
      {"nummerics.safety=0.4", "unknown key 'nummerics', did you mean 'numerics'?"},
      {"numerics.elastic_solver=implict", "did you mean 'implicit'?"},
      {"scene.rate_hz=0", "[scene]: rate_hz is 0, expected a number in Hz from 1 to 1000000"},
      {"heat.rate_hz=-1", "rate_hz is -1, expected"},
      {"material.density=5", "material is no table that occurs once in the file, expected a key of one"},
      {"numerics.safety.x=5", "safety is no table that occurs once"},
      {"numerics.safety=", "the value is not valid TOML, expected"},
      {"numerics.safety=1\n[scene]", "the value is not valid TOML, expected"},
      {"numerics.safety=0.5 0.6", "the value is not valid TOML, expected"},
      {"numerics.safety", "expected TABLE.KEY=VALUE, such as numerics.safety=0.4"},
      {"safety=0.4", "expected TABLE.KEY=VALUE"},
      {".=1", "'' is no name of a table"},
      {"numerics.=1", "'' is no name of a key"},
      {"numerics. safety=1", "' safety' is no name of a key"},
  };
  for (const auto& row : rows) {
    SceneOverrides overrides;
    overrides.settings = {"scene.duration=1", row.setting};
    const std::vector<std::string> faults = faults_of(kScene, overrides);
    ASSERT_EQ(faults.size(), 1u) << row.setting;
    EXPECT_EQ(faults[0].rfind("--set " + printable(row.setting) + ": ", 0), 0u) << faults[0];
    EXPECT_NE(faults[0].find(row.fault), std::string::npos) << faults[0];
  }
}

TEST(SceneFaults, MessagesArePrintable) {
  const std::string bell = "name = \"po\\u0007\\u001b[31mol\"";
  const std::vector<std::string> faults = faults_of(replaced(kScene, "name = \"pool\"", bell));
  ASSERT_FALSE(faults.empty());
  EXPECT_NE(faults[0].find("po\\x07\\x1b[31mol"), std::string::npos) << faults[0];
  EXPECT_EQ(printable("a\xff\xc3\xa9\xc3"), "a\\xff\xc3\xa9\\xc3");
  EXPECT_EQ(printable("\xc2\x80\n"), "\\xc2\\x80\\x0a");
}

TEST(SceneFaults, EmptyFileNamesWhatIsMissing) {
  const std::vector<std::string> faults = faults_of("");
  EXPECT_EQ(faults.size(), 4u);  // scene, domain, spacing, body
}

TEST(SceneFaults, TwoProxiesMayNotShareDeviceOrBody) {
  const std::vector<std::string> faults = faults_of(kScene + "[[proxy]]\ndevice = 1\nbody = \"stick\"\n");
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_NE(faults[0].find("device 1 already drives body 'stick'"), std::string::npos);
  EXPECT_NE(faults[1].find("body 'stick' is already the proxy of device 1"), std::string::npos);
}

TEST(SceneFaults, MissingFileAndFolder) {
  EXPECT_THROW(load_scene("/nowhere/scene.toml"), ConfigError);
  EXPECT_THROW(load_scene(PALP_SOURCE_DIR "/config"), ConfigError);
}

}  // namespace
}  // namespace palp::test::scene_faults_test
