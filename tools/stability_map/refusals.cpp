#include "tools/stability_map/refusals.h"

namespace palp::stability {
namespace {

// A sentence is of the first kind whose phrase it holds; `change` is what in it says what to change.
struct Kind {
  const char* kind;
  const char* phrase;
  const char* change;
};

constexpr Kind kKinds[] = {
    {"sub_steps below the limit", "but a stable step needs at least", "raise it"},
    {"too many sub-steps", "expected at most 10000", "raise"},
    {"too many stages of viscosity", "stages of viscosity", "lower the viscosity"},
    {"bodies overlap", "overlaps body", "move one of them"},
    {"particles in one place", "in one place", "leave one of them out"},
    {"particles too close for an elastic body", "apart", "leave one of them out"},
    {"too far from the origin", "from the origin, where places are rounded", "move the scene to the origin"},
    {"too stiff for single precision", "whose rounding would agitate bodies", "lower young_modulus"},
    {"densities too far apart for method paper", "times as dense as", "bring the densities nearer"},
    {"too soft for its weight", "under its own weight", "raise young_modulus"},
    {"too little damping for method paper", "would swing ever further", "raise damping"},
    {"outside the domain", "outside the domain", "move it"},
    {"period too short", "the domain is periodic", "lengthen the domain"},
    {"surface tension in method paper", "which method \"paper\" does not know", "use method"},
    {"plasticity or tearing in method paper", "which method \"paper\" knows nothing of", "change it"},
    {"implicit solver impossible", "numerics.elastic_solver is \"implicit\"", "leave it out"},
    {"stopped: faster than sound", "faster than the sound speed", "numerics.max_speed is too low"},
    {"stopped: squeezed", "something squeezes the fluid", "raise numerics.max_speed"},
    {"outside its range", ", expected", "expected"},
};

}  // namespace

std::string kind_of_refusal(const std::string& text) {
  const std::string first = text.substr(0, text.find('\n'));
  for (const Kind& k : kKinds)
    if (first.find(k.phrase) != std::string::npos && first.find(k.change) != std::string::npos) return k.kind;
  return "";
}

}  // namespace palp::stability
