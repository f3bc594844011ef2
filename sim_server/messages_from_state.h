// Makes the messages of the server from the scene and from a step's results.
#pragma once

#include "idl/messages.h"
#include "sim_server/solver/simulation.h"

namespace palp {

SceneDescription describe_scene(const Simulation& simulation);
BodyPoses body_poses(const Scene& scene, const StepOutput& output);

enum class ServerState : int { running, paused, fault };

// Returns the server's answer about a proxy after a step. device: the sample that the step was computed from. engaged:
// the hand behind it holds the tool. Wrench and blend are zero unless the server runs.
ProxySample make_proxy_sample(const ProxyOutput& proxy, std::uint32_t device_number, const DeviceSample& device,
                              bool engaged, ServerState state, double sim_time);

// The time after which an answer to a hand is sent again while there is no newer one, for links that lose some: a slow
// server's next one may be long in coming. It is sent again after as much time more, too few times to hide a server
// that stands still.
inline constexpr std::int64_t kRepeatAfterNs = 1'250'000;
inline constexpr int kMostRepeats = 3;
// Returns whether an answer that was sent again `times` times is to be sent once more, and marks it as repeated if so.
bool repeat(ProxySample& sample, int times);

}  // namespace palp
