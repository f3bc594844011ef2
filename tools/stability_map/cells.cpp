#include "tools/stability_map/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tools/stability_map/setup.h"

namespace palp::stability {
namespace {

// The values of an axis that a family goes through. CI leaves out those after "|".
struct Sweep {
  std::string axis;
  std::vector<std::string> values;
};

struct Family {
  std::string name;
  std::string fixed;  // what all its cells have, "/axis=value/..."
  std::vector<Sweep> sweeps;
};

// Matter of each kind over a tray, and what else has a stability of its own.
const std::vector<std::string> kMedia{"fluid+static",      "explicit+static", "implicit+static",
                                      "rigid+static",      "melting+static",  "|",
                                      "staged+static",     "tension+static",  "plastic+static",
                                      "tearing+static",    "freezing+static", "rigidifying+static",
                                      "fluid+rigid+static"};
const std::vector<std::string> kBothMethods{"accurate", "paper"}, kMethod{"accurate", "|", "paper"};
const std::vector<std::string> kFastFirst{"fast", "|", "balanced", "accurate"};

// Returns all pairs of modules, and each alone.
std::vector<std::string> pairs_of_modules() {
  const std::vector<std::string>& names = module_names();
  std::vector<std::string> all;
  for (std::size_t i = 0; i < names.size(); ++i) {
    all.push_back(names[i]);
    for (std::size_t j = i + 1; j < names.size(); ++j) all.push_back(names[i] + "+" + names[j]);
  }
  return all;
}

// clang-format off
std::vector<Family> families() {
  return {
    {"pairs", "", {{"modules", pairs_of_modules()}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"limit", "", {{"modules", {"fluid", "fluid+static", "explicit", "explicit+static", "plastic", "tearing", "tension", "melting", "rigid+static", "|", "staged", "freezing", "implicit"}},
                   {"share", {"0.9", "1.01", "|", "0.5", "0.99", "1.1"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"viscous limit", "/modules=fluid", {{"viscosity", {"1000", "|", "10", "1e4"}}, {"share", {"0.9", "1.01", "|", "0.99"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"damped limit", "/modules=explicit", {{"damping", {"1000", "|", "10", "1e5"}}, {"share", {"0.9", "1.01", "|", "0.99"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"elastic", "/start=touching", {{"modules", {"explicit+static", "implicit+static"}}, {"young", {"1e2", "1e5", "1e9", "1e12", "|", "1e3", "1e4", "1e6", "1e7"}},
                {"poisson", {"-0.9", "0.3", "0.49", "0.4999", "|", "0", "0.495"}}, {"method", kMethod}, {"level", kFastFirst}}},
    {"elastic spin", "/start=spinning/gravity=0", {{"modules", {"explicit", "implicit"}}, {"young", {"1e3", "1e6", "1e9", "|", "1e2", "1e12"}},
                {"poisson", {"0.3", "|", "-0.9", "0.49"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"elastic bond", "/start=bonded", {{"modules", {"explicit+static", "implicit+static", "explicit+rigid+static", "implicit+rigid+static"}}, {"young", {"1e3", "1e6", "|", "1e9"}}, {"damping", {"0", "10"}},
                {"method", kMethod}, {"level", kFastFirst}}},
    {"fluid", "/start=touching/modules=fluid+static", {{"viscosity", {"0", "1", "1e4", "|", "1e-3", "100"}}, {"spacing", {"1e-3", "0.1", "|", "1e-2"}},
                {"method", kBothMethods}, {"level", kFastFirst}}},
    {"tension", "/modules=tension+static", {{"tension", {"0.01", "1", "100", "|", "0.1", "10"}}, {"spacing", {"1e-3", "0.02", "|", "0.1"}}, {"level", kFastFirst}}},
    {"layers", "/start=touching", {{"modules", {"fluid+melting+static", "fluid+explicit+static", "fluid+rigid+static", "explicit+plastic+static"}},
                {"ratio", {"1e-3", "1", "1e3", "|", "0.03", "30"}}, {"method", kMethod}, {"level", kFastFirst}}},
    {"bodies", "", {{"modules", {"rigid+static", "fluid+rigid+static", "explicit+rigid+static", "|", "rigid+plastic+static", "rigid+tearing+static", "rigid+melting+static"}},
                {"mass", {"1e-4", "1", "1e3", "|", "1e-2", "100"}}, {"method", kMethod}, {"level", kFastFirst}}},
    {"hands", "", {{"modules", {"static", "fluid+static", "explicit+static", "implicit+static", "|", "plastic+static", "tearing+static", "rigid+static", "melting+static", "tension+static", "staged+static", "rigidifying+static"}},
                {"hand", {"press", "pass", "shake", "teleport", "wild", "nonsense", "|", "still", "stir", "spin"}}, {"speed", {"1", "100", "|", "10"}}, {"method", kMethod}, {"level", kFastFirst}}},
    {"couplings", "/hand=press", {{"modules", {"static", "fluid+static", "|", "explicit+static", "rigid+static"}}, {"coupling", {"0", "100", "|", "0.1", "10"}},
                {"mass", {"1e-4", "1e3", "|", "1"}}, {"method", kMethod}, {"level", kFastFirst}}},
    {"starts", "", {{"modules", {"fluid+static", "explicit+static", "fluid+rigid", "explicit+plastic", "|", "fluid", "explicit", "implicit", "rigid+static", "plastic", "tearing", "melting+static", "freezing+static", "rigidifying+static", "implicit+rigid+static", "fluid+explicit"}},
                {"start", {"overlapping", "coincident", "close", "inverting", "|", "spinning", "touching"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"sizes", "", {{"modules", kMedia}, {"size", {"one", "line", "sheet", "|", "thousand"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"origin", "", {{"modules", kMedia}, {"origin", {"1000", "|", "10", "-1000"}}, {"spacing", {"0.01", "|", "1e-3", "0.1"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"gravity", "", {{"modules", kMedia}, {"gravity", {"0", "9.81", "-981", "|", "981"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"rates", "", {{"modules", kMedia}, {"rate", {"30", "1e4", "|", "100"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"spacings", "", {{"modules", kMedia}, {"spacing", {"1e-3", "0.1", "|", "0.01"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
    {"safety", "", {{"modules", kMedia}, {"safety", {"1", "|", "0.05", "0.25"}}, {"method", kBothMethods}, {"level", kFastFirst}}},
  };
}
// clang-format on

void combine(const Family& family, std::size_t k, const std::string& name, bool all, std::vector<std::string>& out) {
  if (k == family.sweeps.size()) {
    out.push_back(name);
    return;
  }
  for (const std::string& value : family.sweeps[k].values) {
    if (value == "|" && !all) break;
    if (value != "|") combine(family, k + 1, fmt::format("{}/{}={}", name, family.sweeps[k].axis, value), all, out);
  }
}

}  // namespace

std::vector<std::string> listed_cells(bool all) {
  std::vector<std::string> out;
  for (const Family& family : families()) combine(family, 0, family.name + family.fixed, all, out);
  return out;
}

std::string random_cell(std::uint64_t seed, std::uint64_t k) {
  std::mt19937_64 random(seed * 1000003 + k);
  // not by the library's distributions, which differ between libraries
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(uniform() * static_cast<double>(n)); };
  std::vector<std::string> modules;
  const std::size_t wanted = 1 + below(3);
  while (modules.size() < wanted) {
    const std::string& name = module_names()[below(module_names().size())];
    if (std::find(modules.begin(), modules.end(), name) == modules.end()) modules.push_back(name);
  }
  if (uniform() < 0.6 && std::find(modules.begin(), modules.end(), "static") == modules.end())
    modules.emplace_back("static");
  std::string name = fmt::format("random/modules={}", fmt::join(modules, "+"));
  for (const Axis& axis : axes()) {
    const bool always = axis.name == "method" || axis.name == "level";
    if (axis.name == "share" || (!always && uniform() < 0.6)) continue;
    const bool drawn = axis.high > axis.low && uniform() < 0.8;
    const std::string value = drawn ? fmt::format("{:.3g}", axis.low * std::pow(axis.high / axis.low, uniform()))
                                    : axis.values[below(axis.values.size())];
    name += "/" + axis.name + "=" + value;
  }
  return name;
}

}  // namespace palp::stability
