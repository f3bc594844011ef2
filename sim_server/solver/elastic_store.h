// The elastic bodies as their kernels want them: rest state, neighbours at rest, kernel corrections. Host only.
#pragma once

#include <vector>

#include "sim_server/physics/elastic.h"
#include "sim_server/scene/scene.h"
#include "sim_server/solver/plan.h"

namespace palp {

// The arrays of elastic particles, in the plan's order of forces (ElasticViews).
struct ElasticStore {
  std::vector<Packed> rest, u, v;
  std::vector<Tag> tag;
  std::vector<std::uint32_t> first, neighbor;
  std::vector<Mat3> correction;  // empty with method "paper"
  std::vector<Mat3> projection;  // empty where every neighbourhood fills space and stays whole
  std::vector<Quat> rotation;

  ElasticStore(const Scene& scene, const Plan& plan);
};

}  // namespace palp
