// How deep matter lies in solids that should keep it out: what leaks into walls, and what tools press into or pass
// over.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "sim_server/physics/distance.h"
#include "sim_server/solver/contact_store.h"
#include "sim_server/solver/simulation.h"

namespace palp {

class PenetrationMeter {
 public:
  explicit PenetrationMeter(const Scene& scene);  // keeps a reference to the scene
  // Returns how deep the centre of a particle of a fluid or an elastic body lies in a rigid or fixed one, at most [m];
  // 0 where none does, nothing where no body has a distance field (Body::contact). Copies of bodies across a periodic
  // bound are not looked at. output: of the same step as the snapshot.
  std::optional<double> deepest(const Snapshot& snapshot, const StepOutput& output) const;

  // Calls found(i, d) for each particle i of a fluid or an elastic body that is less than `reach` from the surface of a
  // rigid or fixed one, or within it, once for each such body: at the distance d, negative inside [m].
  using Found = std::function<void(std::size_t particle, double distance)>;
  void each_near(double reach, const Snapshot& snapshot, const StepOutput& output, const Found& found) const;

 private:
  void each_near_body(std::uint32_t body, const ContactBody& shape, double reach, const Snapshot& snapshot,
                      const StepOutput& output, const Found& found) const;

  const Scene& scene_;
  ContactStore store_;
  std::vector<NodeGrid> grids_;
};

}  // namespace palp
