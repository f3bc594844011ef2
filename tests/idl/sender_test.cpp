#include "idl/particle_sender.h"

#include <gtest/gtest.h>

#include <mutex>

#include "idl/clock.h"
#include "idl/frame_assembler.h"
#include "tests/support/bus.h"

namespace palp::test::sender_test {
namespace {

// The chunks that a fake writer keeps, and how it behaves, shared with the test.
struct Wire {
  std::mutex mutex;
  std::vector<ParticleChunk> chunks;
  std::vector<std::int64_t> times_ns;
  std::atomic<int> readers = 1;
  std::atomic<bool> refuse = false;
  std::atomic<int> delay_us = 0;
};

class FakeWriter : public Writer<ParticleChunk> {
 public:
  explicit FakeWriter(std::shared_ptr<Wire> wire) : wire_(std::move(wire)) {}
  bool publish(ParticleChunk& chunk) override {
    if (wire_->refuse) return false;
    std::this_thread::sleep_for(std::chrono::microseconds(wire_->delay_us));
    chunk.header.session = 1;
    ++chunk.header.sequence;
    const std::lock_guard lock(wire_->mutex);
    wire_->chunks.push_back(chunk);
    wire_->times_ns.push_back(now_ns());
    return true;
  }
  int matched_readers() const override { return wire_->readers; }

 private:
  std::shared_ptr<Wire> wire_;
};

void submit(ParticleSender& sender, std::uint64_t number, std::uint32_t n, ScalarField field = ScalarField::speed) {
  ParticleFrame& f = sender.frame();
  f.frame = number;
  f.sim_time = static_cast<double>(number);
  f.field = field;
  f.positions.assign(3 * n, static_cast<float>(number));
  f.scalars.assign(field == ScalarField::none ? 0 : n, static_cast<float>(number));
  sender.submit();
}

TEST(ParticleSender, CutsAFrameIntoSoundChunks) {
  const auto wire = std::make_shared<Wire>();
  ParticleSender sender(std::make_unique<FakeWriter>(wire));
  submit(sender, 7, 10'000);
  ASSERT_TRUE(eventually([&] { return sender.counts().sent == 1; }));
  submit(sender, 8, kChunkParticles, ScalarField::none);
  ASSERT_TRUE(eventually([&] { return sender.counts().sent == 2; }));
  FrameAssembler assembler;
  ParticleFrame out;
  ASSERT_EQ(wire->chunks.size(), 4u);
  for (int i = 0; i < 3; ++i) assembler.add(wire->chunks[i], 0);
  ASSERT_TRUE(assembler.take(out));
  EXPECT_EQ(out.frame, 7u);
  EXPECT_EQ(out.positions, std::vector<float>(30'000, 7.0f));
  EXPECT_EQ(out.scalars, std::vector<float>(10'000, 7.0f));
  assembler.add(wire->chunks[3], 0);
  ASSERT_TRUE(assembler.take(out));
  EXPECT_EQ(out.field, ScalarField::none);
  EXPECT_TRUE(out.scalars.empty());
}

TEST(ParticleSender, KeepsItsPaceBetweenChunks) {
  const auto wire = std::make_shared<Wire>();
  ParticleSender sender(std::make_unique<FakeWriter>(wire), 2ms);
  submit(sender, 1, 10 * kChunkParticles);
  ASSERT_TRUE(eventually([&] { return sender.counts().sent == 1; }));
  ASSERT_EQ(wire->times_ns.size(), 10u);
  // pauses may be longer on a busy machine, never shorter; a microsecond for the clock
  EXPECT_GE(wire->times_ns.back() - wire->times_ns.front(), 9 * 2'000'000 - 1'000'000);
}

TEST(ParticleSender, LetsTheLatestFrameWinAndNeverHoldsTheCaller) {
  const auto wire = std::make_shared<Wire>();
  wire->delay_us = 2000;
  ParticleSender sender(std::make_unique<FakeWriter>(wire));
  std::int64_t longest_ns = 0;
  for (std::uint64_t i = 1; i <= 200; ++i) {
    const std::int64_t t = now_ns();
    submit(sender, i, 9'000);
    longest_ns = std::max(longest_ns, now_ns() - t);
    std::this_thread::sleep_for(200us);
  }
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(wire->mutex);
    return !wire->chunks.empty() && wire->chunks.back().frame == 200 && wire->chunks.back().chunk == 2;
  }));
  ASSERT_TRUE(eventually([&] { return sender.counts().sent + sender.counts().replaced == 200; }));
  EXPECT_GE(sender.counts().replaced, 1u);
  // 200 frames of 3 chunks of 2 ms would take 1.2 s had the caller waited for them
  EXPECT_LT(longest_ns, 1'000'000'000);
  // every frame that began was finished, and none is mixed with another
  FrameAssembler assembler;
  for (const auto& c : wire->chunks) {
    EXPECT_EQ(c.positions.front(), static_cast<float>(c.frame));
    EXPECT_EQ(c.scalars.back(), static_cast<float>(c.frame));
    assembler.add(c, 0);
  }
  EXPECT_EQ(assembler.counts().complete, sender.counts().sent);
  EXPECT_EQ(assembler.counts().incomplete, 0u);
}

TEST(ParticleSender, SendsNothingWhileNobodyListens) {
  const auto wire = std::make_shared<Wire>();
  wire->readers = 0;
  ParticleSender sender(std::make_unique<FakeWriter>(wire));
  submit(sender, 1, 5'000);
  std::this_thread::sleep_for(30ms);
  EXPECT_FALSE(sender.wanted());
  EXPECT_TRUE(wire->chunks.empty());
  wire->readers = 1;
  EXPECT_TRUE(eventually([&] { return sender.wanted(); }));
  submit(sender, 2, 5'000);
  EXPECT_TRUE(eventually([&] { return sender.counts().sent == 1; }));
  EXPECT_EQ(wire->chunks.front().frame, 2u);
}

TEST(ParticleSender, CountsFramesThatCannotBeSentAndChunksThatAreRefused) {
  const auto wire = std::make_shared<Wire>();
  ParticleSender sender(std::make_unique<FakeWriter>(wire));
  for (std::uint64_t bad = 1; bad <= 2; ++bad) {
    sender.frame().positions.assign(9 + bad, 0);
    sender.submit();
    ASSERT_TRUE(eventually([&] { return sender.counts().bad_frames == bad; }));
  }
  wire->refuse = true;
  submit(sender, 2, 5'000);
  ASSERT_TRUE(eventually([&] { return sender.counts().refused_chunks == 2; }));
  EXPECT_TRUE(wire->chunks.empty());
}

TEST(ParticleSender, StopsInTheMiddleOfAFrame) {
  const auto wire = std::make_shared<Wire>();
  const std::int64_t t = now_ns();
  {
    ParticleSender sender(std::make_unique<FakeWriter>(wire), 20ms);
    submit(sender, 1, 4'000'000);
    ASSERT_TRUE(eventually([&] {
      const std::lock_guard lock(wire->mutex);
      return !wire->chunks.empty();
    }));
  }
  // the whole frame would take 20 s
  EXPECT_LT(now_ns() - t, 10'000'000'000);
}

}  // namespace
}  // namespace palp::test::sender_test
