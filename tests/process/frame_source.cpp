// Sends frames of as many particles as wanted without computing them, by the ways that a server has: to measure what a
// viewer gets of them. frame_source VENDOR DOMAIN PARTICLES RATE_HZ SECONDS [bus]; with "bus" without shared memory.
#include <fmt/format.h>
#include <sys/resource.h>

#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>

#include "idl/clock.h"
#include "idl/frame_ring.h"
#include "idl/particle_sender.h"
#include "idl/roster.h"

namespace palp {
namespace {

constexpr double kSpacing = 0.01;  // [m]

SceneDescription block_of(std::uint32_t particles, double width) {
  SceneDescription scene;
  scene.name = "block";
  scene.method = "accurate";
  scene.scene_hash = particles;
  scene.particle_count = particles;
  scene.spacing = kSpacing;
  scene.support_radius = 2 * kSpacing;
  scene.haptic_rate_hz = 1000;
  scene.bounds_max = {width, width, width};
  BodyDescription& body = scene.bodies.emplace_back();
  body.name = "water";
  body.count = particles;
  body.density = 1000;
  body.color = {0.2f, 0.4f, 0.8f};
  return scene;
}

// Puts particle i of a cube, swaying, in its place.
void fill(ParticleFrame& f, std::uint32_t particles, std::uint32_t side, double time) {
  f.sim_time = time;
  f.field = ScalarField::speed;
  f.positions.resize(3 * std::size_t{particles});
  f.scalars.resize(particles);
  const auto sway = static_cast<float>(kSpacing * std::sin(6 * time));
  const auto spacing = static_cast<float>(kSpacing);
  for (std::size_t i = 0; i < particles; ++i) {
    f.positions[3 * i] = spacing * static_cast<float>(i % side) + sway;
    f.positions[3 * i + 1] = spacing * static_cast<float>(i / side % side);
    const std::size_t layer = i / side / side;
    f.positions[3 * i + 2] = spacing * static_cast<float>(layer);
    f.scalars[i] = sway;
  }
}

double cpu_seconds() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

int send_frames(std::span<char*> words) {
  BusOptions options;
  options.vendor = vendor_from(words[1]);
  options.domain = std::atoi(words[2]);
  const auto particles = static_cast<std::uint32_t>(std::atoi(words[3]));
  const double rate_hz = std::atof(words[4]), seconds = std::atof(words[5]);
  const auto side = static_cast<std::uint32_t>(std::ceil(std::cbrt(particles)));
  const auto bus = open_bus(options);
  std::optional<FrameRingWriter> ring;
  if (words.size() < 7) ring.emplace(RingPlace{bus->domain(), bus->session(), particles});
  ParticleSender sender(bus->writer<ParticleChunk>());
  const auto scenes = bus->writer<SceneDescription>();
  const auto statuses = bus->writer<Status>();
  SceneDescription scene = block_of(particles, kSpacing * side);
  scenes->publish(scene);

  const auto period_ns = static_cast<std::int64_t>(1e9 / rate_hz);
  const std::int64_t begin_ns = now_ns();
  std::int64_t due_ns = begin_ns, told_ns = 0, shared_ns = 0;
  std::uint64_t frames = 0, shared = 0, late = 0;
  for (; due_ns - begin_ns < static_cast<std::int64_t>(1e9 * seconds); due_ns += period_ns) {
    sleep_until(due_ns);
    if (now_ns() > due_ns + period_ns) {  // as with a server, what is late is not made up for
      ++late;
      due_ns = now_ns();
    }
    if (due_ns - told_ns > 200'000'000) {
      Status status;
      status.process = kServerName;
      status.state = "running";
      statuses->publish(status);
      told_ns = due_ns;
    }
    const bool by_ring = ring && ring->has_readers();
    if (!by_ring && !sender.wanted()) continue;
    ParticleFrame& frame = sender.frame();
    fill(frame, particles, side, 1e-9 * static_cast<double>(due_ns - begin_ns));
    frame.frame = ++frames;
    const std::int64_t t0 = now_ns();
    if (by_ring && ring->write(frame)) {
      ++shared;
      shared_ns += now_ns() - t0;
    }
    sender.submit();
  }
  const ParticleSender::Counts counts = sender.counts();
  fmt::print(
      "{{\"frames\": {}, \"shared\": {}, \"write_mean_ms\": {:.2f}, \"sent\": {}, \"replaced\": {}, \"late\": {}, "
      "\"cpu_s\": {:.2f}, \"wall_s\": {:.2f}}}\n",
      frames, shared, shared > 0 ? 1e-6 * static_cast<double>(shared_ns) / static_cast<double>(shared) : 0, counts.sent,
      counts.replaced, late, cpu_seconds(), 1e-9 * static_cast<double>(now_ns() - begin_ns));
  return 0;
}

}  // namespace
}  // namespace palp

int main(int argc, char** argv) {
  if (argc < 6) {
    fmt::print(stderr, "frame_source VENDOR DOMAIN PARTICLES RATE_HZ SECONDS [bus]\n");
    return 2;
  }
  return palp::send_frames({argv, static_cast<std::size_t>(argc)});
}
