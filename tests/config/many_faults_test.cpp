// Many faults of one scene are all said, in the order of lines.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tests/config/spoilt_scene.h"

namespace palp::test::many_faults_test {
namespace {

TEST(ManyFaults, ReportsAllFaultsInOrderOfLines) {
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

// A fault of every kind that does not hide another, in every table. Behind #! stands what is to be said of the line.
const char* const kManyFaults = R"([scene]
name = ""                                #! name is "", expected a text
method = "exact"                         #! method is "exact"
accuracy = 3                             #! accuracy is 3
gravity = [1e10, nan, "down"]            #! gravity[0] is 10000000000 #! gravity[1] is nan #! gravity[2] is "down"
body_force = [0, 0]                      #! body_force is an array of 2
gravity_ramp = -1                        #! gravity_ramp is -1
rate_hz = 0                              #! rate_hz is 0
duration = inf                           #! duration is inf
colour = 1                               #! unknown key 'colour' in [scene]
[domain]
min = [0, 0, 0]
max = [1, -1, 1]                         #! max is -1 on axis y
periodic = [true, true]                  #! periodic is an array of 2
[numerics]
spacing = -1                             #! spacing is -1
support_over_spacing = 9                 #! support_over_spacing is 9
sound_speed = 1                          #! expected more than max_speed, which is 2
max_speed = 2
artificial_viscosity = 2                 #! artificial_viscosity is 2
density_diffusion = 2                    #! density_diffusion is 2
shift = 101                              #! shift is 101
viscosity = "thick"                      #! viscosity is "thick"
elastic_solver = "none"                  #! elastic_solver is "none"
tension = 1                              #! tension is 1
sub_steps = 0                            #! sub_steps is 0
safety = 2                               #! safety is 2
[stream]
particle_rate_hz = 1e9                   #! particle_rate_hz is 1000000000
scalar = "smell"                         #! scalar is "smell"
[[material]]                             #! material 'mud': density is missing
name = "mud"
viscosity = -1                           #! viscosity is -1
friction = -1                            #! friction is -1
kinetic_friction = 20                    #! kinetic_friction is 20
restitution = 2                          #! restitution is 2
hardening = 1                            #! hardening is given without yield_stress
tear_strain = 1                          #! tear_strain is given without young_modulus
conductivity = 1                         #! conductivity is given without heat_capacity
melting_temperature = 1                  #! without latent_heat #! without heat_capacity
cooking_time = 1                         #! without cooking_temperature
rigid_when_set = true                    #! rigid_when_set is true, but nothing sets
color = "brown"                          #! color is "brown"
[[material]]                             #! density is missing
name = "mud"                             #! name is taken
[[body]]                                 #! type is missing
name = "a/b"                             #! name is "a/b"
material = "mod"                         #! material 'mod' is not declared
position = [0, 1e99, 1e99]               #! position[1] is #! position[2] is
orientation = [0, 0, 0, 0.5]             #! orientation has length 0.5
bonded_to = "nobody"                     #! 'nobody' in bonded_to
temperature = -1                         #! temperature is -1
hold_temperature = true
[[body.shape]]
type = "blob"                            #! type is "blob"
size = [1, 0, -1]                        #! size[1] is 0 #! size[2] is -1
radius = -1                              #! radius is -1
height = 0                               #! height is 0
scale = 0                                #! scale is 0
[[body.shape]]                           #! radius is missing
type = "sphere"
height = 1                               #! height does not apply to a sphere
rotation_deg = {axis = [0, 0, 0], angle = 400, turn = 1}  #! axis has no length #! angle is 400 #! unknown key 'turn'
[[body]]                                 #! name is missing #! material is missing
type = "elastic"
angular_velocity = [0, 0, 1]             #! only a rigid body has one
[body.shape]                             #! expected tables, each under a line [[body.shape]]
type = "sphere"
radius = -2                              #! radius is -2
[[proxy]]                                #! body is missing
device = 9                               #! device is 9
hand = 1                                 #! hand is 1
handle = 1                               #! handle is 1
coupling_limit = {stiffness = -1, damping = "no"}  #! stiffness is -1 #! damping is "no"
[heat]
loss_to_air = -1                         #! loss_to_air is -1
rate_hz = 0                              #! rate_hz is 0
[[heat_zone]]                            #! neither power nor temperature #! position is missing
name = "fire"
body = "stove"                           #! body 'stove' is not declared
size = [0, 0, 1]                         #! size[0] is 0 #! size[1] is 0
start = 2
end = 1                                  #! end is 1, expected more than start
[[probe]]
name = "where?"                          #! expected at most 64 letters
quantity = "taste"                       #! quantity is "taste"
point = [2, 0, 0]                        #! (2, 0, 0) is outside the domain
body = "nobody"                          #! body 'nobody' is not declared
axis = "w"                               #! axis is "w"
side = "left"                            #! side is "left"
rate_hz = -1                             #! rate_hz is -1
[[probe]]
name = "line"
quantity = "energy"
line = {from = [0, 0, 0], to = 1, count = 1}  #! line does not apply #! to is 1 #! count is 1
body = "nobody"                          #! body 'nobody' is not declared
)";

TEST(ManyFaults, NoFaultHidesAnother) {
  std::vector<std::string> faults = faults_of(kManyFaults);
  std::istringstream lines(kManyFaults);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    for (std::size_t at = line.find("#! "); at != std::string::npos;) {
      const std::size_t next = line.find("#! ", at + 1);
      std::string expected = line.substr(at + 3, next == std::string::npos ? next : next - at - 4);
      expected.erase(expected.find_last_not_of(' ') + 1);
      const std::string where = "a/all.toml:" + std::to_string(number) + ": ";
      const auto found = std::find_if(faults.begin(), faults.end(), [&](const std::string& fault) {
        return fault.rfind(where, 0) == 0 && fault.find(expected) != std::string::npos;
      });
      EXPECT_NE(found, faults.end()) << where << expected;
      if (found != faults.end()) faults.erase(found);
      at = next;
    }
  }
  for (const std::string& fault : faults) ADD_FAILURE() << "said without a reason: " << fault;
}

}  // namespace
}  // namespace palp::test::many_faults_test
