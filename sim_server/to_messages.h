// What the server says on the bus, made from the scene and from a step's results.
#pragma once

#include "idl/messages.h"
#include "sim_server/simulation.h"

namespace palp {

SceneDescription describe_scene(const Simulation& simulation);
BodyPoses body_poses(const Scene& scene, const StepOutput& output);

enum class ServerState : int { running, paused, fault };

// What the server says of a proxy after a step. device: the sample that the step was computed from. engaged: the hand
// behind it holds the tool. Wrench and blend are zero unless the server runs.
ProxySample answer(const ProxyOutput& proxy, std::uint32_t device_number, const DeviceSample& device, bool engaged,
                   ServerState state, double sim_time);

PoseD to_pose(const RigidState& state);
TwistD to_twist(const RigidState& state);
RigidState to_rigid_state(const PoseD& pose, const TwistD& twist);

}  // namespace palp
