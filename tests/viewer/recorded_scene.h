// Recordings of the synthetic scene, as palp-record writes them, without a bus.
#pragma once

#include <string>

#include "idl/mcap/sample_writer.h"
#include "idl/particle_frame.h"
#include "tests/viewer/synthetic_scene.h"

namespace palp::test {

inline std::uint64_t ns_of(double seconds) { return static_cast<std::uint64_t>(std::llround(1e9 * seconds)); }

// Writes one server's messages. log_time and sim_time [s].
class SceneRecorder {
 public:
  explicit SceneRecorder(const std::string& file, std::uint64_t session = 7) : writer_(file, session, true) {
    particles_ = synthetic_scene().scene.particle_count;
  }

  void scene(double log_time, float foam = 0) {
    SceneDescription scene = synthetic_scene().scene;
    scene.bodies[0].look.foam = foam;
    scene.proxies = {{0, 2, synthetic_scene(0).proxy.proxy_pose}};
    writer_.write(scene, ns_of(log_time));
  }

  // A frame, its poses and what the hand feels. chunks: of them so many are written.
  void frame(double log_time, double sim_time, std::uint32_t chunks = 1000) {
    SyntheticScene s = synthetic_scene(sim_time);
    // the scene has a fixed number of particles; the formula has not
    s.frame.positions.resize(3 * particles_, 0.0f);
    s.frame.scalars.resize(particles_, 0.0f);
    s.poses.sim_time = sim_time;
    ++frames_;
    for (std::uint32_t i = 0; i < std::min(chunks, chunks_of(particles_)); ++i) {
      ParticleChunk chunk;
      chunk.frame = frames_;
      chunk.sim_time = sim_time;
      chunk.chunk = i;
      chunk.chunk_count = chunks_of(particles_);
      chunk.first = i * kChunkParticles;
      chunk.particle_count = particles_;
      chunk.field = s.frame.field;
      const auto first = static_cast<std::ptrdiff_t>(chunk.first);
      const auto end = first + static_cast<std::ptrdiff_t>(particles_in_chunk(particles_, i));
      chunk.positions.assign(s.frame.positions.begin() + 3 * first, s.frame.positions.begin() + 3 * end);
      chunk.scalars.assign(s.frame.scalars.begin() + first, s.frame.scalars.begin() + end);
      writer_.write(chunk, ns_of(log_time));
    }
    writer_.write(s.poses, ns_of(log_time));
    writer_.write(s.proxy, ns_of(log_time));
  }

  // Writes what the hand feels, between frames.
  void proxy(double log_time, double sim_time) {
    SyntheticScene s = synthetic_scene(sim_time);
    writer_.write(s.proxy, ns_of(log_time));
  }

  void event(double log_time, const std::string& text) {
    Event event;
    event.process = "sim_server";
    event.severity = Severity::fault;
    event.text = text;
    writer_.write(event, ns_of(log_time));
  }

  void close() { writer_.close({}); }

 private:
  SampleWriter writer_;
  std::uint32_t particles_ = 0;
  std::uint64_t frames_ = 0;
};

// Writes so many frames, a twentieth of a second apart, from time 0.
inline void record_scene(const std::string& file, int frames = 21, float foam = 0) {
  SceneRecorder recorder(file);
  recorder.scene(0, foam);
  for (int i = 0; i < frames; ++i) recorder.frame(0.05 * i, 0.05 * i);
  recorder.close();
}

}  // namespace palp::test
