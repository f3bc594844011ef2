#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <random>

#include "idl/frame_assembler.h"
#include "idl/validate.h"
#include "tests/support/seed.h"

namespace palp::test::assembler_test {
namespace {

constexpr std::uint32_t kTwoChunks = 2 * kChunkParticles;

// The value of every float follows from frame and index, so that a wrong one is seen.
float value_of(std::uint64_t frame, std::size_t index) { return static_cast<float>((frame * 7919 + index) % 1000003); }

std::vector<ParticleChunk> chunks_for(std::uint64_t frame, std::uint32_t n, ScalarField field = ScalarField::speed,
                                      std::uint64_t session = 1) {
  std::vector<ParticleChunk> chunks(chunks_of(n));
  for (std::uint32_t i = 0; i < chunks.size(); ++i) {
    ParticleChunk& c = chunks[i];
    c.header.session = session;
    c.header.sequence = i + 1;
    c.frame = frame;
    c.sim_time = static_cast<double>(frame) / 60;
    c.chunk = i;
    c.chunk_count = static_cast<std::uint32_t>(chunks.size());
    c.first = i * kChunkParticles;
    c.particle_count = n;
    c.field = field;
    const std::uint32_t count = particles_in_chunk(n, i);
    for (std::size_t k = 0; k < 3 * count; ++k) c.positions.push_back(value_of(frame, 3 * c.first + k));
    if (field == ScalarField::none) continue;
    for (std::size_t k = 0; k < count; ++k) c.scalars.push_back(value_of(frame + 1, c.first + k));
  }
  return chunks;
}

void expect_whole(const ParticleFrame& f, std::uint64_t frame, std::uint32_t n, bool scalars = true) {
  EXPECT_EQ(f.frame, frame);
  ASSERT_EQ(f.positions.size(), 3 * std::size_t{n});
  ASSERT_EQ(f.scalars.size(), scalars ? n : 0);
  std::size_t wrong = 0;
  for (std::size_t k = 0; k < f.positions.size(); ++k) wrong += f.positions[k] != value_of(frame, k);
  for (std::size_t k = 0; k < f.scalars.size(); ++k) wrong += f.scalars[k] != value_of(frame + 1, k);
  EXPECT_EQ(wrong, 0u);
}

TEST(Chunks, CoverEveryParticleOnce) {
  for (const std::uint32_t n :
       {0u, 1u, kChunkParticles - 1, kChunkParticles, kChunkParticles + 1, 2 * kChunkParticles, 100000u}) {
    std::uint32_t sum = 0;
    for (std::uint32_t i = 0; i < chunks_of(n); ++i) sum += particles_in_chunk(n, i);
    EXPECT_EQ(sum, n);
  }
  EXPECT_EQ(chunks_of(0), 1u) << "a scene of bodies without particles has frames, too";
}

TEST(FrameAssembler, PutsAFrameTogetherAndGivesItOnce) {
  FrameAssembler assembler;
  const auto chunks = chunks_for(5, 9001);
  ParticleFrame out;
  EXPECT_FALSE(assembler.add(chunks[0], 10));
  EXPECT_FALSE(assembler.add(chunks[1], 20));
  EXPECT_FALSE(assembler.take(out));
  EXPECT_TRUE(assembler.add(chunks[2], 30));
  ASSERT_TRUE(assembler.take(out));
  expect_whole(out, 5, 9001);
  EXPECT_EQ(out.t_receive_ns, 30);
  EXPECT_EQ(out.session, 1u);
  EXPECT_FALSE(assembler.take(out));
}

TEST(FrameAssembler, TakesParticleCountsAndFieldsThatChange) {
  FrameAssembler assembler;
  ParticleFrame out;
  std::uint64_t frame = 0;
  for (const std::uint32_t n : {5000u, 1u, 0u, 12001u, kChunkParticles}) {
    const bool scalars = n != kChunkParticles;
    for (const auto& c : chunks_for(++frame, n, scalars ? ScalarField::density : ScalarField::none))
      assembler.add(c, 0);
    ASSERT_TRUE(assembler.take(out));
    expect_whole(out, frame, n, scalars);
  }
}

// How solid particles are travels with them, in whatever order chunks come; a frame has it wholly or not at all.
TEST(FrameAssembler, KeepsHowSolidParticlesAre) {
  auto chunks = chunks_for(1, kTwoChunks + 5);
  for (ParticleChunk& c : chunks)
    for (std::size_t k = 0; k < c.positions.size() / 3; ++k)
      c.solid.push_back(static_cast<std::uint8_t>((c.first + k) % 251));
  FrameAssembler assembler;
  for (const std::size_t i : {2, 0, 1}) assembler.add(chunks[i], 0);
  ParticleFrame out;
  ASSERT_TRUE(assembler.take(out));
  expect_whole(out, 1, kTwoChunks + 5);
  ASSERT_EQ(out.solid.size(), kTwoChunks + 5);
  std::size_t wrong = 0;
  for (std::size_t k = 0; k < out.solid.size(); ++k) wrong += out.solid[k] != k % 251;
  EXPECT_EQ(wrong, 0u);

  auto next = chunks_for(2, kTwoChunks);
  next[0].solid.assign(kChunkParticles, 7);
  assembler.add(next[0], 0);
  assembler.add(next[1], 0);
  EXPECT_FALSE(assembler.take(out)) << "one chunk has it, the other has not";
  EXPECT_EQ(assembler.counts().refused, 1u);
  next[1].solid.assign(3, 7);
  assembler.add(next[1], 0);
  EXPECT_EQ(assembler.counts().refused, 2u) << "of some particles alone";
}

TEST(FrameAssembler, CountsDuplicatesAndStaleChunks) {
  FrameAssembler assembler;
  const auto first = chunks_for(1, kTwoChunks);
  const auto second = chunks_for(2, kTwoChunks);
  assembler.add(second[0], 0);
  assembler.add(second[0], 0);
  EXPECT_EQ(assembler.counts().duplicate, 1u);
  EXPECT_TRUE(assembler.add(second[1], 0));
  assembler.add(first[0], 0);
  EXPECT_EQ(assembler.counts().late, 1u);
  EXPECT_EQ(assembler.counts().complete, 1u);
}

TEST(FrameAssembler, GivesUpAFrameThatANewerOneOvertakes) {
  FrameAssembler assembler;
  assembler.add(chunks_for(1, kTwoChunks)[0], 0);
  for (const auto& c : chunks_for(2, kTwoChunks)) assembler.add(c, 0);
  ParticleFrame out;
  ASSERT_TRUE(assembler.take(out));
  expect_whole(out, 2, kTwoChunks);
  EXPECT_EQ(assembler.counts().incomplete, 1u);
}

TEST(FrameAssembler, FollowsARestartedServerAndIgnoresTheOldOne) {
  FrameAssembler assembler;
  ParticleFrame out;
  const auto old_frame = chunks_for(1000, kTwoChunks, ScalarField::speed, 1);
  for (const auto& c : old_frame) assembler.add(c, 0);
  for (const auto& c : chunks_for(1, kTwoChunks, ScalarField::speed, 2)) assembler.add(c, 0);
  ASSERT_TRUE(assembler.take(out));
  EXPECT_EQ(out.session, 2u);
  for (const auto& c : chunks_for(1001, kTwoChunks, ScalarField::speed, 1)) EXPECT_FALSE(assembler.add(c, 0));
  EXPECT_FALSE(assembler.take(out));
  // a recording played again: the same session, numbered from the start
  for (const auto& c : chunks_for(500, kTwoChunks, ScalarField::speed, 2)) assembler.add(c, 0);
  ASSERT_TRUE(assembler.take(out));
  for (const auto& c : chunks_for(1, kTwoChunks, ScalarField::speed, 2)) assembler.add(c, 0);
  ASSERT_TRUE(assembler.take(out));
  expect_whole(out, 1, kTwoChunks);
}

TEST(FrameAssembler, RefusesChunksThatContradictThemselvesOrTheirFrame) {
  FrameAssembler assembler;
  const auto good = chunks_for(1, kTwoChunks);
  const auto spoilt = [&](auto change) {
    ParticleChunk c = good[0];
    change(c);
    return assembler.add(c, 0);
  };
  EXPECT_FALSE(spoilt([](ParticleChunk& c) { c.chunk = 2; }));
  EXPECT_FALSE(spoilt([](ParticleChunk& c) { c.first = 1; }));
  EXPECT_FALSE(spoilt([](ParticleChunk& c) { c.particle_count = 0; }));
  EXPECT_FALSE(spoilt([](ParticleChunk& c) { c.chunk_count = 0; }));
  EXPECT_FALSE(spoilt([](ParticleChunk& c) { c.particle_count = 0xffffffff; }));
  EXPECT_FALSE(spoilt([](ParticleChunk& c) { c.positions.pop_back(); }));
  EXPECT_FALSE(spoilt([](ParticleChunk& c) { c.scalars.clear(); }));
  EXPECT_EQ(assembler.counts().refused, 7u);
  assembler.add(good[0], 0);
  assembler.add(chunks_for(1, 8001)[1], 0);
  EXPECT_EQ(assembler.counts().refused, 8u);
  EXPECT_TRUE(assembler.add(good[1], 0));
}

TEST(FrameAssembler, CannotBeHeldUpByHighFrameNumbers) {
  FrameAssembler assembler;
  for (std::uint64_t i = 0; i < 10; ++i) assembler.add(chunks_for(~std::uint64_t{0} - i, kTwoChunks)[0], 0);
  ParticleFrame out;
  for (const auto& c : chunks_for(3, kTwoChunks)) assembler.add(c, 0);
  ASSERT_TRUE(assembler.take(out));
  expect_whole(out, 3, kTwoChunks);
}

TEST(FrameAssembler, TakesMemoryForWhatCameNotForWhatIsClaimed) {
  FrameAssembler assembler;
  ParticleChunk c = chunks_for(1, kChunkParticles)[0];
  c.particle_count = kMaxParticles;
  c.chunk_count = chunks_of(kMaxParticles);
  for (std::uint64_t frame = 1; frame < 1000; ++frame) {
    c.frame = frame;
    EXPECT_FALSE(assembler.add(c, 0));
  }
  ParticleFrame out;
  EXPECT_FALSE(assembler.take(out));
  EXPECT_EQ(assembler.counts().incomplete, 996u);
}

// Random loss, repetition and reordering: each frame all of whose chunks arrive before newer frames push it out is
// whole and right, none is ever wrong, and the numbers never go back.
TEST(FrameAssembler, SurvivesRandomLossAndReordering) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("PALP_SEED=" + std::to_string(seed));
  std::mt19937 random(seed);
  const auto chance = [&](double p) { return std::uniform_real_distribution<double>(0, 1)(random) < p; };

  struct Sent {
    ParticleChunk chunk;
    double at;
  };
  for (int round = 0; round < 8; ++round) {
    const double loss = round % 2 ? 0.03 : 0.0;
    const double jitter = 0.4 * round;  // in frames
    std::vector<Sent> sent;
    std::map<std::uint64_t, std::uint32_t> counts;
    for (std::uint64_t frame = 1; frame <= 30; ++frame) {
      const std::uint32_t n = 1 + random() % 30000;
      counts[frame] = n;
      for (auto& c : chunks_for(frame, n)) {
        const double at =
            static_cast<double>(frame) + c.chunk / 10.0 + jitter * std::generate_canonical<double, 16>(random);
        if (chance(0.02)) sent.push_back({c, at + jitter * 0.1});
        if (!chance(loss)) sent.push_back({std::move(c), at});
      }
    }
    std::stable_sort(sent.begin(), sent.end(), [](const Sent& a, const Sent& b) { return a.at < b.at; });

    FrameAssembler assembler;
    ParticleFrame out;
    std::uint64_t last = 0;
    for (const Sent& s : sent) {
      if (!assembler.add(s.chunk, 0)) continue;
      ASSERT_TRUE(assembler.take(out));
      ASSERT_GT(out.frame, last);
      last = out.frame;
      expect_whole(out, last, counts[last]);
    }
    EXPECT_EQ(assembler.counts().refused, 0u);
    if (loss == 0 && jitter == 0) {
      EXPECT_EQ(assembler.counts().complete, 30u);
    }
    EXPECT_GE(assembler.counts().complete, 1u);
  }
}

}  // namespace
}  // namespace palp::test::assembler_test
