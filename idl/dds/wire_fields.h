// Which field of a message (messages.h) is which field of its wire type (palp.idl): one list, used by both vendors in
// both directions. The vendors' generated types differ in how a field is reached, so who includes this defines
// PALP_WIRE(object, name) first. Included by bus_cyclone.cpp and bus_fastdds.cpp only.
#pragma once

#include <concepts>
#include <type_traits>

#include "idl/topics.h"

#ifndef PALP_WIRE
#error "define PALP_WIRE(object, name) before including wire_fields.h"
#endif

namespace palp {

template <class T, class U>
concept MessageOf = std::same_as<std::remove_const_t<T>, U>;

#define PALP_FIELD(name) op(m.name, PALP_WIRE(w, name))

template <class Op, MessageOf<Header> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(version);
  PALP_FIELD(session);
  op(m.sequence, PALP_WIRE(w, sequence_number));
  PALP_FIELD(t_send_ns);
}

template <class Op, MessageOf<PoseD> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(position);
  PALP_FIELD(orientation);
}

template <class Op, MessageOf<TwistD> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(linear);
  PALP_FIELD(angular);
}

template <class Op, MessageOf<WrenchD> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(force);
  PALP_FIELD(torque);
}

template <class Op, MessageOf<CouplingGains> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(stiffness);
  PALP_FIELD(damping);
  PALP_FIELD(angular_stiffness);
  PALP_FIELD(angular_damping);
}

template <class Op, MessageOf<DeviceSample> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(header);
  PALP_FIELD(device);
  PALP_FIELD(flags);
  PALP_FIELD(t_device_ns);
  PALP_FIELD(pose);
  PALP_FIELD(twist);
  PALP_FIELD(gains);
}

template <class Op, MessageOf<ProxySample> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(header);
  PALP_FIELD(device);
  PALP_FIELD(flags);
  PALP_FIELD(sim_time);
  PALP_FIELD(device_session);
  PALP_FIELD(device_sequence);
  PALP_FIELD(t_device_ns);
  PALP_FIELD(device_pose);
  PALP_FIELD(device_twist);
  PALP_FIELD(proxy_pose);
  PALP_FIELD(proxy_twist);
  PALP_FIELD(wrench);
  PALP_FIELD(gains);
  PALP_FIELD(blend);
  PALP_FIELD(energy);
}

template <class Op, MessageOf<ParticleChunk> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(header);
  PALP_FIELD(frame);
  PALP_FIELD(sim_time);
  PALP_FIELD(chunk);
  PALP_FIELD(chunk_count);
  PALP_FIELD(first);
  PALP_FIELD(particle_count);
  PALP_FIELD(field);
  PALP_FIELD(positions);
  PALP_FIELD(scalars);
}

template <class Op, MessageOf<BodyDescription> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(name);
  PALP_FIELD(kind);
  PALP_FIELD(first);
  PALP_FIELD(count);
  PALP_FIELD(density);
  PALP_FIELD(color);
  PALP_FIELD(vertices);
  PALP_FIELD(triangles);
}

template <class Op, MessageOf<ProxyDescription> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(device);
  PALP_FIELD(body);
  PALP_FIELD(pose);
}

template <class Op, MessageOf<SceneDescription> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(header);
  PALP_FIELD(name);
  PALP_FIELD(method);
  PALP_FIELD(numerics);
  PALP_FIELD(scene_hash);
  PALP_FIELD(particle_count);
  PALP_FIELD(spacing);
  PALP_FIELD(support_radius);
  PALP_FIELD(haptic_rate_hz);
  PALP_FIELD(bounds_min);
  PALP_FIELD(bounds_max);
  PALP_FIELD(gravity);
  PALP_FIELD(bodies);
  PALP_FIELD(proxies);
}

template <class Op, MessageOf<BodyPoses> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(header);
  PALP_FIELD(sim_time);
  PALP_FIELD(body);
  PALP_FIELD(pose);
}

template <class Op, MessageOf<Metric> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(name);
  PALP_FIELD(value);
}

template <class Op, MessageOf<Status> M, class W>
void map_fields(Op& op, M& m, W& w) {
  op.derived(process_key(m.process), PALP_WIRE(w, process_key));
  PALP_FIELD(header);
  PALP_FIELD(process);
  PALP_FIELD(state);
  PALP_FIELD(text);
  PALP_FIELD(metrics);
}

template <class Op, MessageOf<Event> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(header);
  PALP_FIELD(process);
  PALP_FIELD(severity);
  PALP_FIELD(sim_time);
  PALP_FIELD(text);
}

template <class Op, MessageOf<Command> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(header);
  PALP_FIELD(kind);
  PALP_FIELD(name);
  PALP_FIELD(value);
}

template <class Op, MessageOf<CommandReply> M, class W>
void map_fields(Op& op, M& m, W& w) {
  PALP_FIELD(header);
  PALP_FIELD(command_session);
  PALP_FIELD(command_sequence);
  PALP_FIELD(ok);
  PALP_FIELD(text);
}

#undef PALP_FIELD

}  // namespace palp
