// The names of what a scene makes the solver hold and launch: it is to pay only for what it contains.
#pragma once

#include <algorithm>
#include <iterator>
#include <set>
#include <string>

#include "sim_server/solver/plan.h"
#include "tests/support/backend.h"

namespace palp::test {

using Names = std::set<std::string>;

struct Contents {
  Names arrays, launches;
};

// Runs a scene until all of its stages have been launched.
inline Contents contents_of(const Scene& scene) {
  const auto simulation = simulate(scene);
  const int interval = make_plan(scene).heat_interval;
  for (int k = 0; k < interval; ++k) simulation->step({});
  const Footprint f = simulation->footprint();
  Contents c;
  for (const auto& [name, bytes] : f.arrays) c.arrays.insert(name);
  c.launches.insert(f.launches.begin(), f.launches.end());
  return c;
}

// Returns what `more` has and `base` has not.
inline Names added(const Names& base, const Names& more) {
  Names out;
  std::set_difference(more.begin(), more.end(), base.begin(), base.end(), std::inserter(out, out.end()));
  return out;
}

}  // namespace palp::test
