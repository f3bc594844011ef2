// The fields of every message (messages.h), once and in the order of palp.idl: from these lists come the way to the
// wire and back, for both vendors and without one, and the check that no number is infinite or none at all. In a list,
// FIELD(NAME) is a field of the same name on the wire; RENAMED(NAME, WIRE_NAME) one that palp.idl calls otherwise;
// DERIVED(WIRE_NAME, VALUE) one that the wire alone has, made from the message `m`.
#pragma once

// NOLINTBEGIN(bugprone-macro-parentheses): lists of names
#define PALP_FIELDS_OF_Header(FIELD, RENAMED, DERIVED) \
  FIELD(version) FIELD(session) RENAMED(sequence, sequence_number) FIELD(t_send_ns)
#define PALP_FIELDS_OF_PoseD(FIELD, RENAMED, DERIVED) FIELD(position) FIELD(orientation)
#define PALP_FIELDS_OF_TwistD(FIELD, RENAMED, DERIVED) FIELD(linear) FIELD(angular)
#define PALP_FIELDS_OF_WrenchD(FIELD, RENAMED, DERIVED) FIELD(force) FIELD(torque)
#define PALP_FIELDS_OF_CouplingGains(FIELD, RENAMED, DERIVED) \
  FIELD(stiffness) FIELD(damping) FIELD(angular_stiffness) FIELD(angular_damping)
#define PALP_FIELDS_OF_DeviceSample(FIELD, RENAMED, DERIVED) \
  FIELD(device) FIELD(header) FIELD(flags) FIELD(t_device_ns) FIELD(pose) FIELD(twist) FIELD(gains)
#define PALP_FIELDS_OF_ProxySample(FIELD, RENAMED, DERIVED) \
  FIELD(device)                                             \
  FIELD(header)                                             \
  FIELD(flags)                                              \
  FIELD(sim_time)                                           \
  FIELD(device_session)                                     \
  FIELD(device_sequence)                                    \
  FIELD(t_device_ns)                                        \
  FIELD(device_pose)                                        \
  FIELD(device_twist) FIELD(proxy_pose) FIELD(proxy_twist) FIELD(wrench) FIELD(gains) FIELD(blend) FIELD(energy)
#define PALP_FIELDS_OF_ParticleChunk(FIELD, RENAMED, DERIVED) \
  FIELD(header)                                               \
  FIELD(frame)                                                \
  FIELD(sim_time)                                             \
  FIELD(chunk)                                                \
  FIELD(chunk_count) FIELD(first) FIELD(particle_count) FIELD(field) FIELD(positions) FIELD(scalars) FIELD(solid)
#define PALP_FIELDS_OF_Look(FIELD, RENAMED, DERIVED) \
  FIELD(clear)                                       \
  FIELD(roughness)                                   \
  FIELD(metallic) FIELD(refractive_index) FIELD(absorption_per_m) FIELD(scattering_length) FIELD(grain) FIELD(foam)
#define PALP_FIELDS_OF_BodyDescription(FIELD, RENAMED, DERIVED) \
  FIELD(name)                                                   \
  FIELD(kind)                                                   \
  FIELD(first)                                                  \
  FIELD(count)                                                  \
  FIELD(density)                                                \
  FIELD(color) FIELD(look) FIELD(vertices) FIELD(triangles) FIELD(changed_color) FIELD(changed_look) FIELD(rest)
#define PALP_FIELDS_OF_ProxyDescription(FIELD, RENAMED, DERIVED) FIELD(device) FIELD(body) FIELD(pose)
#define PALP_FIELDS_OF_SceneDescription(FIELD, RENAMED, DERIVED) \
  FIELD(header)                                                  \
  FIELD(name)                                                    \
  FIELD(method)                                                  \
  FIELD(numerics)                                                \
  FIELD(scene_hash)                                              \
  FIELD(particle_count)                                          \
  FIELD(spacing)                                                 \
  FIELD(support_radius)                                          \
  FIELD(haptic_rate_hz) FIELD(bounds_min) FIELD(bounds_max) FIELD(gravity) FIELD(bodies) FIELD(proxies)
#define PALP_FIELDS_OF_BodyPoses(FIELD, RENAMED, DERIVED) FIELD(header) FIELD(sim_time) FIELD(body) FIELD(pose)
#define PALP_FIELDS_OF_Metric(FIELD, RENAMED, DERIVED) FIELD(name) FIELD(value)
#define PALP_FIELDS_OF_Status(FIELD, RENAMED, DERIVED) \
  DERIVED(process_key, process_key(m.process)) FIELD(header) FIELD(process) FIELD(state) FIELD(text) FIELD(metrics)
#define PALP_FIELDS_OF_Event(FIELD, RENAMED, DERIVED) \
  FIELD(header) FIELD(process) FIELD(severity) FIELD(sim_time) FIELD(text)
#define PALP_FIELDS_OF_Command(FIELD, RENAMED, DERIVED) FIELD(header) FIELD(kind) FIELD(name) FIELD(value)
#define PALP_FIELDS_OF_CommandReply(FIELD, RENAMED, DERIVED) \
  FIELD(header) FIELD(command_session) FIELD(command_sequence) FIELD(ok) FIELD(text)
// NOLINTEND(bugprone-macro-parentheses)

// Runs macro for every struct that is a part of a message; those that hold others after what they hold.
#define PALP_FOR_EACH_PART(macro)                                                                                 \
  macro(Header) macro(PoseD) macro(TwistD) macro(WrenchD) macro(CouplingGains) macro(Look) macro(BodyDescription) \
      macro(ProxyDescription) macro(Metric)
