// Whole frames of 100,000 particles with a scalar each, 60 a second, through receive buffers of Debian's default size:
// every frame arrives complete and right, between both vendors in every direction. Those of a million are whole by
// shared memory.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>

#include "idl/clock.h"
#include "idl/frame_assembler.h"
#include "idl/frame_ring.h"
#include "idl/particle_sender.h"
#include "tests/support/bus.h"

namespace palp::test::frames_test {
namespace {

constexpr std::uint32_t kParticles = 100'000;
constexpr std::uint64_t kFrames = 60;
constexpr int kRuns = 6;
constexpr std::int64_t kFrameNs = 1'000'000'000 / 60;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr double kRequired = 0;  // ten times slower, the reader cannot keep up: only the values are checked
#else
constexpr double kRequired = 0.98;
#endif

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

struct Result {
  ParticleSender::Counts sent;
  FrameAssembler::Counts arrived;
  DropCounts drops;
  std::size_t wrong = 0;
};

Result send_and_receive(ParticleSender& sender, Reader<ParticleChunk>& reader) {
  const ParticleSender::Counts before = sender.counts();
  std::thread producer([&] {
    std::int64_t t = now_ns();
    for (std::uint64_t i = 1; i <= kFrames; ++i) {
      fill(sender.frame(), i);
      sender.submit();
      t += kFrameNs;
      std::this_thread::sleep_for(std::chrono::nanoseconds(std::max<std::int64_t>(0, t - now_ns())));
    }
  });
  Result result;
  FrameAssembler assembler;
  ParticleFrame frame;
  std::vector<Received<ParticleChunk>> chunks;
  const std::int64_t t_end = now_ns() + 20'000'000'000;
  while (frame.frame < kFrames && now_ns() < t_end) {
    result.sent = sender.counts();
    const auto done = result.sent.sent + result.sent.replaced - before.sent - before.replaced;
    if (!reader.wait(300ms) && done >= kFrames) break;
    chunks.clear();
    reader.take_all(chunks);
    for (const auto& chunk : chunks) assembler.add(chunk);
    if (assembler.take(frame)) result.wrong += wrong_values(frame);
  }
  producer.join();
  result.sent = sender.counts();
  result.sent.sent -= before.sent;
  result.sent.replaced -= before.replaced;
  result.arrived = assembler.counts();
  result.drops = reader.drops();
  return result;
}

class Frames : public testing::TestWithParam<Pairing> {};

// A stall of a busy machine may cost chunks in one run; it takes a wrong pace to cost some in every run.
TEST_P(Frames, ArriveCompleteThroughDefaultSocketBuffers) {
  BusOptions to = options_for(std::get<1>(GetParam()));
  to.socket_buffer_bytes = 212992;  // what net.core.rmem_max allows on a plain Debian
  const auto sender_bus = open_bus(options_for(std::get<0>(GetParam())));
  const auto reader_bus = open_bus(to);
  ParticleSender sender(sender_bus->writer<ParticleChunk>());
  const auto reader = reader_bus->reader<ParticleChunk>();
  ASSERT_TRUE(eventually([&] { return sender.wanted() && reader->matched_writers() > 0; }));

  bool complete = false;
  for (int run = 0; run < kRuns && !complete; ++run) {
    const Result r = send_and_receive(sender, *reader);
    std::cout << "frames: " << r.sent.sent << " sent, " << r.sent.replaced << " replaced, " << r.arrived.complete
              << " complete, " << r.arrived.incomplete << " incomplete\n";
    ASSERT_EQ(r.wrong, 0u);
    ASSERT_EQ(r.sent.refused_chunks + r.sent.bad_frames + r.drops.malformed + r.drops.not_finite, 0u);
    complete =
        r.sent.sent > 0 && static_cast<double>(r.arrived.complete) >= kRequired * static_cast<double>(r.sent.sent);
  }
  EXPECT_TRUE(complete);
}

// How many of them are taken is a matter of the machine: two copies of 16 MB for each.
TEST(MillionParticles, ArriveWholeBySharedMemory) {
  constexpr std::uint32_t kMillion = 1'000'000;
  const RingPlace place{test_domain(), static_cast<std::uint64_t>(now_ns()), kMillion};
  FrameRingWriter writer(place);
  FrameRingReader reader(place);
  std::atomic<bool> done = false;
  std::thread producer([&] {
    ParticleFrame f;
    f.field = ScalarField::speed;
    f.positions.assign(3 * kMillion, 0);
    f.scalars.assign(kMillion, 0);
    std::int64_t t = now_ns();
    for (f.frame = 1; f.frame <= kFrames; ++f.frame) {
      // values from end to end of both arrays tell whether they are of this frame
      for (std::size_t k = 0; k < kMillion; k += 999) f.positions[3 * k] = f.scalars[k] = value_of(f.frame, k);
      EXPECT_TRUE(writer.write(f));
      t = std::max(t + kFrameNs, now_ns());  // what is late is not made up for by haste
      sleep_until(t);
    }
    done = true;
  });
  std::uint64_t frames = 0, wrong = 0;
  ParticleFrame out;
  for (bool last = false; !last; std::this_thread::sleep_for(2ms)) {
    last = done;
    const RingAnswer answer = reader.take(out);
    EXPECT_NE(answer, RingAnswer::refused);
    if (answer != RingAnswer::frame) continue;
    ++frames;
    for (std::size_t k = 0; k < kMillion; k += 999) {
      const float value = value_of(out.frame, k);
      wrong += out.positions[3 * k] != value || out.scalars[k] != value;
    }
  }
  producer.join();
  std::cout << "frames: " << kFrames << " written, " << frames << " taken\n";
  EXPECT_GT(frames, 0u);
  EXPECT_EQ(wrong, 0u);
}

INSTANTIATE_TEST_SUITE_P(Vendors, Frames,
                         testing::Combine(testing::Values(Vendor::cyclone, Vendor::fastdds),
                                          testing::Values(Vendor::cyclone, Vendor::fastdds)),
                         pairing_name<testing::TestParamInfo<Pairing>>);

}  // namespace
}  // namespace palp::test::frames_test
