// The solver's equations restated from their definitions: every pair, double precision, no cells, no tricks. What the
// solver does is compared with this, so nothing here may call its code beyond the plan's numbers and the scene.
#pragma once

#include <vector>

#include <Eigen/Dense>

#include "sim_server/solver/plan.h"
#include "sim_server/solver/simulation.h"

namespace palp::test {

// One rigid body; its proxy's handle if it has one.
struct RestatedBody {
  Eigen::Vector3d x, v, w, L;  // of the centre of mass; angular momentum
  Eigen::Quaterniond q;
  std::vector<Eigen::Vector3d> local;  // particles relative to the centre of mass, body axes
  Eigen::Vector3d handle = Eigen::Vector3d::Zero();
  int proxy = -1;
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();  // of the last sub-step
  Eigen::Vector3d coupling = Eigen::Vector3d::Zero();  // force on the handle in the last sub-step
  double work[2] = {0, 0};                             // that the coupling did on the handle's side, linear and angular
  // The sizes of what was summed to force, torque and work: a sum that nearly cancels is no less uncertain for it.
  double force_size = 0, torque_size = 0, work_size[2] = {0, 0};
  double work_rounding = 0;  // the most that linear work changes where the body's place is rounded [J]
};

struct Restated {
  const Scene* scene;
  Plan plan;
  std::vector<Eigen::Vector3d> x, v;
  std::vector<double> p, V, m;
  std::vector<RestatedBody> body;
  std::vector<double> wall_pressure;
  std::vector<Eigen::Vector3d> wall_velocity, force;
  std::vector<Eigen::Vector3d> slope, smooth;  // of particle shifting: S and s
  std::vector<double> strain;                  // e
  std::vector<int> layer;
  int steps = 0;  // haptic steps done
};

Restated restate(const Scene& scene);
// One sub-step, `elapsed` seconds of the haptic step being over at its end.
void sub_step(Restated& world, const StepInput& input, double elapsed);
// Returns the density of a fluid particle by its equation of state.
double density_of(const Restated& world, std::size_t particle);
// Returns the state of the handle of a proxy.
RigidState handle_of(const Restated& world, std::size_t proxy);

// Returns the largest distance of a particle's place in a snapshot from that in the world, by the shortest way, over
// the spacing.
double places_apart(const Restated& world, const Snapshot& snapshot);

}  // namespace palp::test
