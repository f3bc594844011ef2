// A subscriber of particles: puts the chunks of each frame together and prints how high the particles are.
// Usage: particle_subscriber [FRAMES [DOMAIN]], beside palp-sim-server.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <vector>

#include "idl/bus.h"
#include "idl/frame_assembler.h"

namespace {

void print_frame(const palp::ParticleFrame& frame) {
  const std::size_t count = frame.positions.size() / 3;
  double sum = 0;
  float top = count > 0 ? frame.positions[2] : 0;
  for (std::size_t i = 0; i < count; ++i) {
    sum += frame.positions[3 * i + 2];
    top = std::max(top, frame.positions[3 * i + 2]);
  }
  std::printf("%.3f s: %zu particles, mean height %.4f m, highest %.4f m\n", frame.sim_time, count,
              count > 0 ? sum / static_cast<double>(count) : 0, top);
}

void subscribe(int frames, int domain) {
  palp::BusOptions options;
  options.domain = domain;
  const auto bus = palp::open_bus(options);
  const auto chunks = bus->reader<palp::ParticleChunk>();
  palp::FrameAssembler assembler;
  palp::ParticleFrame frame;
  std::vector<palp::Received<palp::ParticleChunk>> arrived;
  for (int seen = 0; seen < frames;) {
    chunks->wait(std::chrono::milliseconds(100));
    arrived.clear();
    chunks->take_all(arrived);
    for (const auto& chunk : arrived) assembler.add(chunk);
    if (!assembler.take(frame)) continue;
    print_frame(frame);
    ++seen;
  }
}

}  // namespace

int main(int argc, char** argv) try {
  subscribe(argc > 1 ? std::atoi(argv[1]) : 100, argc > 2 ? std::atoi(argv[2]) : 0);
} catch (const std::exception& error) {
  std::fprintf(stderr, "particle_subscriber: %s\n", error.what());
  return 1;
}
