#include "tools/run_recording.h"

#include <chrono>
#include <cmath>
#include <thread>

#include "idl/particle_frame.h"
#include "sim_server/messages_from_state.h"
#include "sim_server/probes/probes.h"

namespace palp {
namespace {

constexpr double kStatusRate = 4;  // [Hz], as a server sends them

std::uint64_t stamp_of(double seconds) { return static_cast<std::uint64_t>(std::llround(1e9 * seconds)); }

// A number for the headers that follows from the scene, so that the same run gives the same file.
std::uint64_t session_of(const Scene& scene) { return scene.config.hash | 1; }

}  // namespace

RunRecording::RunRecording(const Simulation& simulation, const std::string& path, bool overwrite)
    : writer_(path, session_of(simulation.scene()), overwrite) {
  SceneDescription scene = describe_scene(simulation);
  writer_.write(scene, 0);
}

void RunRecording::write_state(Simulation& simulation, const StepOutput& output, std::vector<ProxySample> answers) {
  const SceneConfig& config = simulation.scene().config;
  for (ProxySample& answer : answers) writer_.write(answer, stamp_of(output.time));
  if (rate_due(output.step, kStatusRate, config.rate_hz)) {
    Status status;
    status.process = "sim_server";
    status.state = output.health.ok ? "running" : "fault";
    status.text = output.health.cause;
    writer_.write(status, stamp_of(output.time));
  }
  if (rate_due(output.step, config.stream.particle_rate_hz, config.rate_hz)) write_frame(simulation, output);
}

void RunRecording::write_frame(Simulation& simulation, const StepOutput& output) {
  const ScalarField field = simulation.scene().config.stream.scalar;
  simulation.begin_frame(field);
  while (!simulation.take_frame(frame_)) std::this_thread::sleep_for(std::chrono::microseconds(100));
  ++frames_;
  const auto count = static_cast<std::uint32_t>(frame_.position.size() / 3);
  for (std::uint32_t i = 0; i < chunks_of(count); ++i) {
    ParticleChunk chunk;
    chunk.frame = frames_;
    chunk.sim_time = output.time;
    chunk.field = field;
    fill_chunk(i, frame_.position, frame_.scalar, frame_.solid, chunk);
    writer_.write(chunk, stamp_of(output.time));
  }
  BodyPoses poses = body_poses(simulation.scene(), output);
  if (!poses.body.empty()) writer_.write(poses, stamp_of(output.time));
}

void RunRecording::close() {
  std::map<std::string, std::string> description{
      {"started", "in simulated time"}, {"dds", "palp-run"}, {"domain", "none"}};
  // nothing was sent, so nothing was lost
  for (const TopicRow& topic : kTopics)
    for (const char* what : {"dropped ", "lost "}) description[std::string(what) + topic.name] = "0";
  writer_.close(description);
}

}  // namespace palp
