// Whole frames of 100,000 particles with a scalar each, 60 a second, through receive buffers of Debian's default size:
// every frame arrives complete and right, between both vendors in every direction.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>

#include "idl/clock.h"
#include "idl/frame_assembler.h"
#include "idl/particle_sender.h"
#include "tests/wire/support.h"

namespace palp::test {
namespace {

constexpr std::uint32_t kParticles = 100'000;
constexpr int kFrames = 90;
constexpr std::int64_t kFrame_ns = 1'000'000'000 / 60;

float value_of(std::uint64_t frame, std::size_t index) { return static_cast<float>((frame * 7919 + index) % 1000003); }

void fill(ParticleFrame& f, std::uint64_t frame) {
  f.frame = frame;
  f.sim_time = static_cast<double>(frame) / 60;
  f.field = ScalarField::speed;
  f.positions.resize(3 * kParticles);
  f.scalars.resize(kParticles);
  for (std::size_t k = 0; k < f.positions.size(); ++k) f.positions[k] = value_of(frame, k);
  for (std::size_t k = 0; k < f.scalars.size(); ++k) f.scalars[k] = value_of(frame + 1, k);
}

std::size_t wrong_values(const ParticleFrame& f) {
  std::size_t wrong = f.positions.size() != 3 * kParticles || f.scalars.size() != kParticles;
  for (std::size_t k = 0; k < f.positions.size(); ++k) wrong += f.positions[k] != value_of(f.frame, k);
  for (std::size_t k = 0; k < f.scalars.size(); ++k) wrong += f.scalars[k] != value_of(f.frame + 1, k);
  return wrong;
}

class Frames : public testing::TestWithParam<Pairing> {};

TEST_P(Frames, ArriveCompleteThroughDefaultSocketBuffers) {
  BusOptions to = options_for(std::get<1>(GetParam()));
  to.socket_buffer_bytes = 212992;  // what net.core.rmem_max allows on a plain Debian
  const auto sender_bus = open_bus(options_for(std::get<0>(GetParam())));
  const auto reader_bus = open_bus(to);
  ParticleSender sender(sender_bus->writer<ParticleChunk>());
  const auto reader = reader_bus->reader<ParticleChunk>();
  ASSERT_TRUE(eventually([&] { return sender.wanted() && reader->matched_writers() > 0; }));

  std::thread producer([&] {
    std::int64_t t = now_ns();
    for (int i = 1; i <= kFrames; ++i) {
      fill(sender.frame(), static_cast<std::uint64_t>(i));
      sender.submit();
      t += kFrame_ns;
      std::this_thread::sleep_for(std::chrono::nanoseconds(std::max<std::int64_t>(0, t - now_ns())));
    }
  });
  FrameAssembler assembler;
  ParticleFrame frame;
  std::vector<Received<ParticleChunk>> chunks;
  std::size_t wrong = 0;
  std::vector<double> ages_ms;
  const std::int64_t t_end = now_ns() + 20'000'000'000;
  while (frame.frame < kFrames && now_ns() < t_end) {
    if (!reader->wait(500ms)) {
      if (sender.counts().sent + sender.counts().replaced >= kFrames) break;
      continue;
    }
    chunks.clear();
    reader->take_all(chunks);
    for (const auto& chunk : chunks) assembler.add(chunk);
    if (!assembler.take(frame)) continue;
    wrong += wrong_values(frame);
    ages_ms.push_back(static_cast<double>(frame.t_receive_ns - frame.t_send_ns) * 1e-6);
  }
  producer.join();
  const auto sent = sender.counts();
  const auto counts = assembler.counts();
  std::sort(ages_ms.begin(), ages_ms.end());
  std::cout << "frames: " << sent.sent << " sent, " << sent.replaced << " replaced, " << counts.complete
            << " complete, " << counts.incomplete << " incomplete; chunks lost: " << reader->drops().lost
            << "; median from first chunk to last: " << (ages_ms.empty() ? 0 : ages_ms[ages_ms.size() / 2]) << " ms\n";
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(sent.refused_chunks, 0u);
  EXPECT_EQ(sent.bad_frames, 0u);
  EXPECT_EQ(reader->drops().malformed, 0u);
  EXPECT_GE(static_cast<double>(counts.complete), 0.95 * static_cast<double>(sent.sent));
}

INSTANTIATE_TEST_SUITE_P(Vendors, Frames,
                         testing::Combine(testing::Values(Vendor::cyclone, Vendor::fastdds),
                                          testing::Values(Vendor::cyclone, Vendor::fastdds)),
                         pairing_name<testing::TestParamInfo<Pairing>>);

}  // namespace
}  // namespace palp::test
