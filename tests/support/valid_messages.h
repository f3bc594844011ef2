// Messages that the checks let pass, every field of them used.
#pragma once

#include "idl/messages.h"
#include "idl/topics.h"

namespace palp::test {

inline PoseD sound_pose() { return {{0.1, 0.2, 0.3}, {0.5, -0.5, 0.5, 0.5}}; }
inline TwistD sound_twist() { return {{1, 2, 3}, {4, 5, 6}}; }
inline CouplingGains sound_gains() { return {500, 1, 0.5, 0.001}; }

inline void make_sound(DeviceSample& m) {
  m.device = 3;
  m.flags = kEngaged | kHealthy;
  m.t_device_ns = 12345;
  m.pose = sound_pose();
  m.twist = sound_twist();
  m.gains = sound_gains();
}
inline void make_sound(ProxySample& m) {
  m.device = 3;
  m.flags = kEngaged;
  m.sim_time = 1.5;
  m.device_session = 77;
  m.device_sequence = 78;
  m.t_device_ns = 79;
  m.device_pose = m.proxy_pose = sound_pose();
  m.device_twist = m.proxy_twist = sound_twist();
  m.wrench = {{1, 2, 3}, {0.1, 0.2, 0.3}};
  m.gains = sound_gains();
  m.blend = {0.25, 1};
  m.energy = {-1, 2};
}
inline void make_sound(ParticleChunk& m) {
  m.frame = 9;
  m.sim_time = 0.5;
  m.chunk = 1;
  m.chunk_count = 2;
  m.first = kChunkParticles;
  m.particle_count = kChunkParticles + 2;
  m.field = ScalarField::speed;
  m.positions = {1, 2, 3, 4, 5, 6};
  m.scalars = {7, 8};
  m.solid = {0, 255};
}
inline void make_sound(SceneDescription& m) {
  m.name = "tray";
  m.method = "accurate";
  m.numerics = "spacing 5 mm";
  m.scene_hash = 0xfeedfacecafebeef;
  m.particle_count = 100;
  m.spacing = 0.005;
  m.support_radius = 0.01;
  m.haptic_rate_hz = 1000;
  m.bounds_min = {-1, -2, -3};
  m.bounds_max = {1, 2, 3};
  m.gravity = {0, 0, -9.81};
  m.bodies.resize(3);
  m.bodies[0] = {"water",
                 BodyKind::fluid,
                 0,
                 88,
                 1000,
                 {0.1f, 0.2f, 1.0f},
                 {true, 0.05f, 0, 1.333f, {3, 2, 1}, 0.5f, 0},
                 {},
                 {},
                 {1, 1, 0.5f},
                 {true, 0.12f, 0, 1.31f, {1, 2, 3}, 0.02f, 0},
                 {}};
  m.bodies[1] = {"spoon", BodyKind::rigid, 90, 10, 7800, {0, 1, 0}, {}, {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}, {}, {},
                 {}};
  m.bodies[2] = m.bodies[1];
  m.bodies[2].name = "jelly";
  m.bodies[2].kind = BodyKind::elastic;
  m.bodies[2].first = 88;
  m.bodies[2].count = 2;
  m.bodies[2].rest = {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f};
  m.proxies = {{3, 1, sound_pose()}};
}
inline void make_sound(BodyPoses& m) {
  m.sim_time = 0.25;
  m.body = {1, 2};
  m.pose = {sound_pose(), sound_pose()};
}
inline void make_sound(Status& m) {
  m.process = "sim_server";
  m.state = "running";
  m.text = "all is well";
  m.metrics = {{"step_p50_us", 61.5}, {"real_time_factor", 1}};
}
inline void make_sound(Event& m) {
  m.process = "sim_server";
  m.severity = Severity::warning;
  m.sim_time = 2;
  m.text = "slow motion";
}
inline void make_sound(Command& m) {
  m.kind = CommandKind::set_parameter;
  m.name = "viscosity";
  m.value = "0.1";
}
inline void make_sound(CommandReply& m) {
  m.command_session = 5;
  m.command_sequence = 6;
  m.ok = true;
  m.text = "done";
}

template <class T>
T sound() {
  T m;
  m.header.session = 1;
  m.header.sequence = 1;
  make_sound(m);
  return m;
}

}  // namespace palp::test
