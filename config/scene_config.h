// A scene file, read strictly: what the user asked for, with defaults filled in and every value inside its range.
// The grammar, units and ranges are documented in config/scenes/README.md, which a test compares with the reader.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "idl/gains.h"
#include "idl/look.h"
#include "idl/vocabulary.h"

namespace palp {

enum class Method { paper, accurate };
enum class Accuracy { fast, balanced, accurate };
enum class ViscosityScheme { explicit_, staged };
enum class ElasticSolver { explicit_, implicit };

// `look` of a material or a body: a name, and what is said otherwise (config/looks.h).
struct LookConfig {
  std::string base;                           // empty: what follows from the physics
  std::optional<std::array<float, 3>> color;  // sRGB
  // as of Look
  std::optional<bool> clear;
  std::optional<float> roughness, metallic, refractive_index;
  std::optional<std::array<float, 3>> absorption_per_m;
  std::optional<float> scattering_length, grain, foam;
};

// sRGB, on the bus for bodies of which nothing says look or colour: viewers tell these apart by colours of their own.
inline constexpr std::array<float, 3> kNoColor{0.3f, 0.5f, 0.9f};

struct MaterialConfig {
  std::string name;
  double density = 1000;       // rest density [kg/m^3]
  double viscosity = 1e-3;     // dynamic viscosity [Pa s]; fluids, and as the viscosity a wall shows to a fluid
  double surface_tension = 0;  // [N/m]; fluids
  double adhesion = 0;         // to solids [N/m]; fluids
  std::optional<double> young_modulus;        // [Pa], elastic bodies need one
  double poisson_ratio = 0.3;                 // -0.9..0.495
  double damping = 0;                         // viscosity of the elastic solid (Kelvin-Voigt) [Pa s]
  std::optional<double> yield_stress;         // [Pa], of elastic bodies; unset: does not yield
  std::optional<double> tear_strain;          // of elastic bodies; unset: does not tear
  double hardening = 0;                       // [Pa], more yield stress for each unit of plastic strain
  double friction = 0.3;                      // of solids, static coefficient
  double kinetic_friction = 0.3;              // at most the static one
  double restitution = 0.2;                   // of solids, speed after over speed before a bounce
  double conductivity = 0;                    // [W/(m K)]; 0: an insulator
  double heat_capacity = 0;                   // [J/(kg K)]; 0: not given
  std::optional<double> melting_temperature;  // [K]; unset: does not melt
  double latent_heat = 0;                     // [J/kg], above 0 when it melts
  std::optional<double> cooking_temperature;  // from which it sets for good [K]; unset: never
  double cooking_time = 1;                    // that it takes [s]
  std::optional<double> rigid_below;          // solid matter colder than this is rigid [K]; unset: none is
  bool rigid_when_set = false;                // what has set for good is rigid
  std::optional<std::array<float, 3>> color;  // sRGB
  std::optional<LookConfig> look;             // unset: what follows from the physics
  std::optional<LookConfig> changed_look;     // of what has changed state: cooked, molten, frozen; unset: likewise
  std::string where;                          // file:line, for messages
};

enum class ShapeType { box, sphere, cylinder, mesh, particles };

// One solid of a body. A body is the first shape, then each next one added or (subtract) removed, in order.
struct ShapeConfig {
  ShapeType type = ShapeType::box;
  bool subtract = false;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // of the shape's centre in the body frame [m]
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // box: edge lengths [m]
  double radius = 0;                               // sphere, cylinder [m]
  double height = 0;                               // cylinder, along its z [m]
  std::string file;  // mesh (OBJ, STL, PLY) or particles (CSV), resolved against the scene
  double scale = 1;  // mesh: metres per file unit
  std::string where;
};

struct BodyConfig {
  std::string name;
  BodyKind type = BodyKind::fluid;
  std::string material;
  std::vector<ShapeConfig> shapes;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // of the body frame in the world [m]
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity =
      Eigen::Vector3d::Zero();  // initial [m/s]; fixed: of the wall's surface, which does not move
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // initial [rad/s], rigid only
  std::optional<double> temperature;                           // initial [K]
  bool hold_temperature = false;                               // it stays as at the start
  std::vector<std::string> bonded_to;                          // elastic only: rigid and static bodies it holds on to
  std::optional<std::array<float, 3>> color;                   // overrides the material's
  std::optional<LookConfig> look;                              // overrides the material's
  std::string where;
};

struct ProxyConfig {
  unsigned device = 0;
  std::string body;                                  // a rigid body
  Eigen::Vector3d handle = Eigen::Vector3d::Zero();  // coupling point in the body frame [m]
  CouplingGains coupling_limit = kDefaultGains;      // the most the server lets a bridge ask for
  std::string hand;  // file of the hand script that a simulated arm plays here; empty: none is named
  std::string where;
};

// The heat that the air takes from free surfaces, and how often heat is computed.
struct HeatConfig {
  double loss_to_air = 0;        // [W/(m^2 K)]
  double air_temperature = 293;  // [K]
  // Heat is computed at least this often, or as often as there are haptic steps; unset: 20, or 100 where something
  // changes state.
  std::optional<double> rate_hz;
};

// A box in which all particles are heated, or held at a temperature.
struct HeatZoneConfig {
  std::string name;
  std::string body;                                    // whose frame it moves with, rigid or static; empty: the world
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // of its centre in that frame [m]
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // edge lengths [m]
  double power = 0;                                // [W], shared by volume among the particles in it
  std::optional<double> temperature;               // instead of power [K]
  double start = 0, end = 1e300;                   // on from start to end [s]
  std::string where;
};

enum class Quantity {
  pressure,
  density,
  velocity,
  temperature,
  wall_pressure,
  front,
  energy,
  extremes,
  body,
  heat,
  pieces
};

struct ProbeConfig {
  std::string name;
  Quantity quantity = Quantity::pressure;
  std::vector<Eigen::Vector3d> points;  // world [m]: one point, or a line's points
  std::string body;                     // body: which one; front, energy, extremes: optional restriction to one body
  int axis = 0;                         // front: 0 x, 1 y, 2 z
  bool front_max = true;                // front: largest (else smallest) coordinate
  double rate_hz = 100;
  std::string where;
};

// Overrides of what the accuracy level expands to. Unset: derived (sim_server/solver/plan.h says how).
struct NumericsConfig {
  std::optional<double> spacing;                // particle spacing dx [m], after the accuracy level is applied
  std::optional<double> support_over_spacing;   // H / dx, 1.8..4
  std::optional<double> sound_speed;            // [m/s]
  std::optional<double> max_speed;              // expected largest speed [m/s], from which the sound speed follows
  std::optional<double> artificial_viscosity;   // alpha, 0..1
  std::optional<double> density_diffusion;      // delta, 0..0.5
  std::optional<double> shift;                  // k of particle shifting, 0..100
  std::optional<ViscosityScheme> viscosity;     // unset: what costs less
  std::optional<ElasticSolver> elastic_solver;  // unset: what costs less
  std::optional<int> elastic_rounds;         // of an implicit solve, at most; unset: what leaves a hundredth to solve
  std::optional<bool> tension;               // let fluid pressure be negative
  std::optional<int> sub_steps;              // per haptic step; refused when unstable
  std::optional<int> fluid_interval;         // haptic steps that fluids take at once; refused where they cannot
  std::optional<double> skin_over_spacing;   // by which neighbour lists reach past H, over dx, 0.02..1
  std::optional<double> sleep_speed;         // what is slower rests and is not computed (physics/sleep.h) [m/s]
  std::optional<double> region_of_interest;  // distance from tools within which nothing sleeps [m]
  bool solid_particles = false;              // all rigid and fixed bodies have particles, needed or not
  std::string where;                         // file:line of sound_speed or max_speed, for messages
  double safety = 0.5;                       // fraction of the linear stability limit that a sub-step uses, 0.05..1
};

struct StreamConfig {
  double particle_rate_hz = 60;
  ScalarField scalar = ScalarField::speed;
};

// The choice of --budget or --error: by what it was made, and what it is expected to cost and err
// (sim_server/trade/choice.h).
struct NumericsChoice {
  std::string asked;                  // "a budget of 500 us"
  double spacing = 0;                 // [m]
  std::vector<std::string> settings;  // TABLE.KEY=VALUE each
  double expected_step = 0;           // median of a haptic step while the hand moves [s]
  double expected_step_p99 = 0;       // [s]
  double expected_error = 0;          // of the force, rms over rms
  double uncertainty = 0;             // of the reference that errors were measured against, as a share of the force
  std::string machine_class;          // of this machine
  double speed = 1;                   // of this machine over that of the table
  std::string measured_with;          // the scene whose curve served
  bool own_curve = false;             // that is this scene
  std::string table, table_date, table_commit;
};

struct SceneConfig {
  std::string path;  // of the file
  std::string name;
  std::string description;
  Method method = Method::accurate;
  Accuracy accuracy = Accuracy::balanced;
  Eigen::Vector3d gravity{0, 0, -9.81};                  // [m/s^2], balanced by pressure in a closed tank
  Eigen::Vector3d body_force = Eigen::Vector3d::Zero();  // [m/s^2], drives a flow (periodic channels)
  double gravity_ramp = 0;                               // [s] gravity grows from zero over this time
  double rate_hz = 1000;                                 // haptic steps per second of simulated time
  double duration = 10;                                  // [s], default for palp-run
  Eigen::Vector3d domain_min = Eigen::Vector3d::Zero();
  Eigen::Vector3d domain_max = Eigen::Vector3d::Zero();
  std::array<bool, 3> periodic{};
  NumericsConfig numerics;
  StreamConfig stream;
  std::vector<MaterialConfig> materials;
  std::vector<BodyConfig> bodies;
  std::vector<ProxyConfig> proxies;
  HeatConfig heat;
  std::vector<HeatZoneConfig> heat_zones;
  std::vector<ProbeConfig> probes;
  std::uint64_t hash = 0;  // of the file's text and the overrides
  // Shared by the copies of a scene: what is expected is known when the simulation that holds one was timed.
  std::shared_ptr<const NumericsChoice> choice;  // none: a level or a spacing was given
};

// Overrides from the command line. Each, when set, wins over the file.
struct SceneOverrides {
  std::optional<Method> method;
  std::optional<Accuracy> accuracy;
  std::optional<double> spacing;
  std::vector<std::string> settings;  // TABLE.KEY=VALUE each, a later one wins over an earlier; read as the file is
  bool solid_particles = false;       // true: as if numerics.solid_particles were
};

// Reads a scene. Throws ConfigError (config/error.h) that lists every fault found: file:line, what, what was expected.
SceneConfig load_scene(const std::string& path, const SceneOverrides& overrides = {});

const char* to_string(Method method);
const char* to_string(Accuracy accuracy);

}  // namespace palp
