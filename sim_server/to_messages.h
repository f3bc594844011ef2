// What the server says on the bus, made from the scene and from a step's results.
#pragma once

#include "idl/messages.h"
#include "sim_server/simulation.h"

namespace palp {

SceneDescription describe_scene(const Simulation& simulation);
BodyPoses body_poses(const Scene& scene, const StepOutput& output);

PoseD to_pose(const RigidState& state);
TwistD to_twist(const RigidState& state);
RigidState to_rigid_state(const PoseD& pose, const TwistD& twist);

}  // namespace palp
