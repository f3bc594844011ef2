// A setup is what one cell of the stability map asks of the simulation: a value on each axis, and the text that names
// it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_server/solver/simulation.h"

namespace palp::stability {

// Parts of the simulation that a scene of the map can be made of; matter first, then what acts on it.
enum class Module : std::uint8_t {
  fluid,
  staged,  // a fluid whose viscosity is applied in stages
  tension,
  elastic_explicit,
  elastic_implicit,
  plastic,
  tearing,
  rigid,
  melting,      // solid at the start and in the warmth
  freezing,     // liquid at the start and in the cold
  rigidifying,  // solid, and rigid where it is cold enough
  fixed,        // a tray below
  heat,
  proxy,
  periodic,
  count
};

// How large bodies are: a single particle, three in a row, a sheet of one layer, a block, a block of a thousand.
enum class Size : std::uint8_t { one, line, sheet, block, thousand };

enum class Start : std::uint8_t {
  apart,        // a spacing between bodies
  touching,     // no room between them
  overlapping,  // by half a spacing
  coincident,   // one body where another is, a single one with two particles in one place
  close,        // two particles of each fluid a hundredth of a spacing apart
  inverting,    // matter that changes its shape flies through its own middle
  spinning,
  bonded  // elastic bodies hold on to the tray
};

enum class Hand : std::uint8_t { none, still, press, stir, shake, pass, teleport, spin, wild, nonsense };

struct Setup {
  Method method = Method::accurate;
  Accuracy level = Accuracy::fast;
  std::uint32_t modules = 0;  // bit k: Module k
  double spacing = 0.02;      // [m]
  double rate = 1000;         // haptic steps per second [Hz]
  double gravity = -9.81;     // along z [m/s^2]
  double origin = 0;          // distance of the scene from the origin along each axis [m]
  double young = 1e5;         // [Pa]
  double poisson = 0.3;
  double damping = 0;      // of elastic bodies [Pa s]
  double viscosity = 0.1;  // [Pa s]
  double tension = 0.072;  // [N/m]
  double density = 1000;   // of the lowest body [kg/m^3]
  double ratio = 1;        // density of each other body over that
  double mass = 0;         // of rigid bodies and tools [kg]; 0: that of 2000 kg/m^3
  double friction = 0.3;
  double conductivity = 50;  // [W/(m K)]
  double speed = 1;          // of the hand [m/s]
  double coupling = 1;       // coupling limit over its defaults
  double safety = 0.5;       // numerics.safety
  double share = 0;          // sub-step over its linear limit, one a haptic step; 0: as planned
  Size size = Size::block;
  Start start = Start::apart;
  Hand hand = Hand::none;

  bool has(Module m) const { return (modules >> static_cast<unsigned>(m) & 1u) != 0; }
  void add(Module m) { modules |= 1u << static_cast<unsigned>(m); }
};

// One axis of the map. Random cells draw from `values` or, where high is above low, evenly from the logarithms of
// [low, high].
struct Axis {
  std::string name;
  std::vector<std::string> values;
  double low = 0, high = 0;
};

// All axes but the modules, in the order in which names list them.
const std::vector<Axis>& axes();
// The modules' names, by Module.
const std::vector<std::string>& module_names();

// Returns the setup that a cell's name asks for: "FAMILY/axis=value/...", the modules as "modules=fluid+rigid". Axes
// that it does not name keep their defaults. Throws ConfigError that says what was expected.
Setup setup_of(const std::string& cell);

}  // namespace palp::stability
