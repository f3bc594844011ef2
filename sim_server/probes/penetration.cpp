#include "sim_server/probes/penetration.h"

#include <algorithm>

#include "sim_server/probes/snapshot_points.h"
#include "sim_server/solver/plan.h"

namespace palp {

PenetrationMeter::PenetrationMeter(const Scene& scene)
    : scene_(scene), store_(scene, make_plan(scene)), grids_(store_.grids_at(store_.node.data())) {}

std::optional<double> PenetrationMeter::deepest(const Snapshot& snapshot, const StepOutput& output) const {
  if (store_.shape.empty()) return {};
  double deepest = 0;
  each_near(0, snapshot, output, [&](std::size_t, double distance) { deepest = std::max(deepest, -distance); });
  return deepest;
}

void PenetrationMeter::each_near(double reach, const Snapshot& snapshot, const StepOutput& output,
                                 const Found& found) const {
  std::size_t shape = 0;  // in the order of the bodies that have one
  for (std::uint32_t b = 0; b < scene_.bodies.size(); ++b)
    if (scene_.bodies[b].contact != nullptr) each_near_body(b, store_.shape[shape++], reach, snapshot, output, found);
}

void PenetrationMeter::each_near_body(std::uint32_t body, const ContactBody& shape, double reach,
                                      const Snapshot& snapshot, const StepOutput& output, const Found& found) const {
  const RigidState& state = output.bodies[body].state;
  const Eigen::Matrix3d to_body = state.orientation.conjugate().toRotationMatrix();
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(reach);
  const Eigen::AlignedBox3d bounds(shape.low.cast<double>() - margin, shape.high.cast<double>() + margin);
  for (const Body& matter : scene_.bodies) {
    if (matter.type != BodyKind::fluid && matter.type != BodyKind::elastic) continue;
    for (std::size_t i = matter.first; i < matter.first + matter.count; ++i) {
      if (is_inactive(snapshot, i)) continue;
      const Vec3 x = (to_body * (place_of(snapshot, i) - state.position) - scene_.bodies[body].center).cast<real>();
      if (!bounds.contains((shape.R.transpose() * (x - shape.c)).cast<double>())) continue;
      const double distance = solid_distance(shape, store_.piece.data(), grids_.data(), x).d;
      if (distance < reach) found(i, distance);
    }
  }
}

}  // namespace palp
