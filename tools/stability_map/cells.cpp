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
    {"hands", "", {{"modules", {"static", "fluid+static", "explicit+static", "implicit+static", "plastic+static", "|", "tearing+static", "rigid+static", "melting+static", "tension+static", "staged+static", "rigidifying+static"}},
                {"hand", {"press", "pass", "shake", "teleport", "wild", "nonsense", "|", "still", "stir", "spin"}}, {"speed", {"1", "100", "|", "10"}}, {"method", kMethod}, {"level", kFastFirst}}},
    {"couplings", "/hand=press", {{"modules", {"static", "fluid+static", "|", "explicit+static", "rigid+static"}}, {"coupling", {"0", "100", "|", "0.1", "1", "3", "10"}},
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

// Returns random products (palp-stability --random) that were faults once. Each stands for a cause that was mended,
// which must not come back.
std::vector<std::string> found_by_chance() {
  // clang-format off
  return {
    "random/modules=periodic+static/method=paper/level=fast/spacing=0.00102/rate=177/damping=1e4/tension=0.00154/density=1000/conductivity=0.867/speed=0.307/coupling=1.22/hand=still",
    "random/modules=tearing+periodic+static/method=accurate/level=balanced/rate=90.7/origin=-1000/young=4.19e+08/poisson=0/viscosity=0.144/density=987/speed=4.51",
    "random/modules=proxy+static/method=paper/level=fast/rate=251/young=149/poisson=0.49/viscosity=1.95e+03/coupling=1",
    "random/modules=static/method=accurate/level=balanced/damping=0/tension=0.072/density=1.28e+03/ratio=0.0278/mass=0.126/friction=0/size=line/start=overlapping",
    "random/modules=staged/method=paper/level=fast/spacing=0.02/rate=6.41e+03/gravity=9.81/origin=1000/poisson=0/damping=0/viscosity=144/mass=330/coupling=1",
    "random/modules=rigid+plastic+proxy+static/method=accurate/level=fast/rate=1000/gravity=9.81/viscosity=0.1/ratio=19.6/coupling=0.876/size=block/start=overlapping",
    "random/modules=melting/method=paper/level=fast/spacing=0.0291/gravity=0/origin=10/poisson=0.49/viscosity=41/tension=54.6/conductivity=4.6/safety=0.5",
    "random/modules=fluid+static/method=paper/level=fast/rate=6.97e+03/origin=-1000/young=1.7e+06/poisson=0.495/tension=43.2/ratio=0.0264/conductivity=1.28/safety=0.5",
    "random/modules=static+plastic/method=accurate/level=accurate/origin=0/young=1.21e+03/poisson=0.49/density=448/ratio=73.5/coupling=1.47/safety=0.5/size=thousand",
    "random/modules=static+proxy/method=paper/level=balanced/rate=797/origin=10/poisson=0.495/damping=1/viscosity=6.41e+03/density=1000/friction=1/conductivity=2.87/speed=0.938/coupling=0.46/start=apart",
    "random/modules=explicit+static/method=paper/level=accurate/spacing=0.00341/rate=1000/origin=0/young=3.29e+07/poisson=0.49/density=179/ratio=10.2/mass=0.0757/conductivity=55.4/safety=1/start=touching/hand=pass",
    "random/modules=tearing+static/method=accurate/level=accurate/spacing=0.00882/gravity=-981/poisson=0.495/viscosity=8.16/conductivity=0.941/speed=0.787/safety=0.5/size=block/hand=press",
    "random/modules=rigidifying+static/method=accurate/level=balanced/rate=344/poisson=0.45/damping=1e4/mass=0.00456/friction=0.3/coupling=0.923/safety=0.5/start=close",
    "random/modules=freezing+explicit+implicit/method=paper/level=accurate/spacing=0.00184/gravity=9.81/damping=1/viscosity=0.0259/tension=29.1/density=127/friction=0.3/conductivity=50/size=sheet",
    "random/modules=rigid+explicit+staged+static/method=paper/level=fast/rate=233/origin=10/young=1e5/viscosity=0/density=1000/mass=0.00507/friction=0/coupling=9.36/safety=1/size=block/start=overlapping",
    "random/modules=rigidifying+proxy+static/method=paper/level=fast/spacing=0.0502/rate=1000/gravity=-981/damping=0/tension=45/density=2.93/ratio=0.0128/coupling=0.188/size=block/start=bonded",
    "random/modules=staged+melting/method=accurate/level=fast/spacing=0.02/origin=0/young=130/damping=0/tension=0.0103/conductivity=50/size=one/hand=press",
    "random/modules=explicit+tension+rigid/method=accurate/level=balanced/gravity=9.81/young=1.51e+04/viscosity=0.1/density=2.74/mass=171/conductivity=2.75e+03/start=overlapping/hand=spin",
    "random/modules=rigid/method=accurate/level=accurate/gravity=-981/viscosity=51.4/density=7.02/speed=3.29/coupling=1/size=sheet/start=overlapping/hand=still",
    "random/modules=rigid+explicit+fluid/method=accurate/level=balanced/tension=0.0147/density=3.27/speed=2.03/coupling=0.142/size=one/start=overlapping/hand=still",
    "random/modules=rigid+periodic+static/method=accurate/level=balanced/spacing=0.00231/gravity=0/young=1.99e+11/viscosity=127/tension=0.072/density=1.13e+04/safety=0.5/start=touching",
    "random/modules=periodic/method=accurate/level=fast/rate=221/origin=10/poisson=0.45/damping=0/density=1000/mass=0.000172/speed=2.01/hand=still",
    "random/modules=periodic+proxy+tearing+static/method=accurate/level=balanced/spacing=0.00708/gravity=-9.81/young=2.89e+06/poisson=0.49/ratio=1/mass=0.00193/friction=0/conductivity=4.24/speed=13/coupling=65.9",
    "random/modules=explicit+periodic+static/method=accurate/level=balanced/spacing=0.025/rate=226/gravity=-9.81/origin=-1000/young=1e5/tension=0.112/density=1.69/mass=0.0195/speed=0.744/coupling=0.797/start=bonded",
    "random/modules=explicit+static/method=accurate/level=balanced/spacing=0.0178/origin=-1000/density=4.79/ratio=0.00531/mass=7.75/speed=1/coupling=8.36/safety=0.5/start=inverting",
    "random/modules=explicit+static/method=accurate/level=balanced/young=3.29e+09/poisson=0.3/damping=0/friction=10/coupling=3.04/safety=0.25/start=inverting/hand=stir",
    "random/modules=fluid+static+proxy/method=accurate/level=balanced/rate=55.8/gravity=-981/poisson=0/tension=1.9/ratio=1/mass=319/speed=17.9/coupling=0.127/safety=1/start=spinning/hand=shake",
    "random/modules=tearing+periodic/method=accurate/level=balanced/spacing=0.02/origin=0/young=1e5/poisson=0.495/mass=0.00706/speed=1.55/coupling=1/safety=0.5/start=inverting/hand=press",
    "random/modules=tearing+static/method=accurate/level=accurate/spacing=0.0474/rate=242/origin=1000/young=1.64e+08/density=12.1/start=inverting",
    "random/modules=tearing+static/method=accurate/level=fast/spacing=0.02/poisson=0.49/tension=0.233/density=46.3/mass=1.07/friction=0.3/start=inverting",
  };
  // clang-format on
}

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
  for (std::string& name : found_by_chance()) out.push_back(std::move(name));
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
