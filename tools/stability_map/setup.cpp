#include "tools/stability_map/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "config/error.h"
#include "config/text_file.h"

namespace palp::stability {
namespace {

const std::vector<std::string> kMethods{"accurate", "paper"};
const std::vector<std::string> kLevels{"fast", "balanced", "accurate"};
const std::vector<std::string> kSizes{"one", "line", "sheet", "block", "thousand"};
const std::vector<std::string> kStarts{"apart", "touching",  "overlapping", "coincident",
                                       "close", "inverting", "spinning",    "bonded"};
const std::vector<std::string> kHands{"none", "still",    "press", "stir", "shake",
                                      "pass", "teleport", "spin",  "wild", "nonsense"};
const std::vector<std::string> kModules{"fluid",       "staged",  "tension", "explicit", "implicit",
                                        "plastic",     "tearing", "rigid",   "melting",  "freezing",
                                        "rigidifying", "static",  "heat",    "proxy",    "periodic"};

struct Number {
  const char* name;
  double Setup::*member;
  double low, high;  // that random cells draw from
  std::vector<std::string> values;
};

// The ranges are those of section "Extremes" of the map's page; where zero is allowed, or a number may be negative,
// the values say so.
const std::vector<Number> kNumbers{
    {"spacing", &Setup::spacing, 1e-3, 0.1, {"0.02"}},
    {"rate", &Setup::rate, 30, 1e4, {"1000"}},
    {"gravity", &Setup::gravity, 0, 0, {"-9.81", "0", "9.81", "-981"}},
    {"origin", &Setup::origin, 0, 0, {"0", "0", "0", "10", "1000", "-1000"}},
    {"young", &Setup::young, 1e2, 1e12, {"1e5"}},
    {"poisson", &Setup::poisson, 0, 0, {"-0.9", "-0.5", "0", "0.3", "0.45", "0.49", "0.495", "0.4999"}},
    {"damping", &Setup::damping, 0, 0, {"0", "0", "1", "100", "1e4"}},
    {"viscosity", &Setup::viscosity, 1e-3, 1e4, {"0", "0.1"}},
    {"tension", &Setup::tension, 1e-3, 100, {"0.072"}},
    {"density", &Setup::density, 1, 2e4, {"1000"}},
    {"ratio", &Setup::ratio, 1e-3, 1e3, {"1"}},
    {"mass", &Setup::mass, 1e-4, 1e3, {"0"}},
    {"friction", &Setup::friction, 0, 0, {"0", "0.3", "1", "10"}},
    {"conductivity", &Setup::conductivity, 0.1, 1e4, {"50"}},
    {"speed", &Setup::speed, 0.1, 100, {"1"}},
    {"coupling", &Setup::coupling, 0.1, 100, {"1"}},
    {"safety", &Setup::safety, 0, 0, {"0.5", "0.5", "0.5", "0.5", "0.25", "1"}},
    {"share", &Setup::share, 0, 0, {"0"}},
};

template <class Enum>
void choose(const std::vector<std::string>& names, const std::string& axis, const std::string& text, Enum& out) {
  const auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end())
    throw ConfigError(fmt::format("{} is '{}', expected one of {}", axis, text, fmt::join(names, ", ")));
  out = static_cast<Enum>(found - names.begin());
}

void set_modules(const std::string& text, Setup& setup) {
  std::istringstream in(text);
  for (std::string name; std::getline(in, name, '+');) {
    Module module{};
    choose(kModules, "modules", name, module);
    setup.add(module);
  }
}

void set_axis(const std::string& axis, const std::string& text, Setup& setup) {
  if (axis == "modules") return set_modules(text, setup);
  if (axis == "method") {
    std::size_t index = 0;
    choose(kMethods, axis, text, index);
    setup.method = index == 0 ? Method::accurate : Method::paper;
    return;
  }
  if (axis == "level") return choose(kLevels, axis, text, setup.level);
  if (axis == "size") return choose(kSizes, axis, text, setup.size);
  if (axis == "start") return choose(kStarts, axis, text, setup.start);
  if (axis == "hand") return choose(kHands, axis, text, setup.hand);
  const auto number =
      std::find_if(kNumbers.begin(), kNumbers.end(), [&](const Number& row) { return row.name == axis; });
  if (number == kNumbers.end())
    throw ConfigError(fmt::format("'{}' is no axis of the map; expected modules, {}", axis, [] {
      std::vector<std::string> names;
      for (const Axis& a : axes()) names.push_back(a.name);
      return fmt::format("{}", fmt::join(names, ", "));
    }()));
  const auto value = parse_number(text);
  if (!value) throw ConfigError(fmt::format("{} is '{}', expected a number", axis, text));
  setup.*number->member = *value;
}

}  // namespace

const std::vector<std::string>& module_names() { return kModules; }

const std::vector<Axis>& axes() {
  static const std::vector<Axis> all = [] {
    std::vector<Axis> list{{"method", kMethods}, {"level", kLevels}};
    for (const Number& n : kNumbers) list.push_back({n.name, n.values, n.low, n.high});
    list.push_back({"size", kSizes});
    list.push_back({"start", kStarts});
    list.push_back({"hand", kHands});
    return list;
  }();
  return all;
}

Setup setup_of(const std::string& cell) {
  Setup setup;
  std::istringstream in(cell);
  std::string part;
  std::getline(in, part, '/');  // the family
  while (std::getline(in, part, '/')) {
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos) throw ConfigError(fmt::format("cell '{}': '{}' is no axis=value", cell, part));
    set_axis(part.substr(0, equals), part.substr(equals + 1), setup);
  }
  if (setup.modules == 0) throw ConfigError(fmt::format("cell '{}' has no modules=, expected one or more", cell));
  if (setup.hand != Hand::none) setup.add(Module::proxy);
  if (setup.has(Module::proxy) && setup.hand == Hand::none) setup.hand = Hand::press;
  return setup;
}

}  // namespace palp::stability
