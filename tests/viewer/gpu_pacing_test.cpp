// When the pieces of a picture are drawn beside a server that steps on the same GPU, in a made-up time.
#include "viewer/gpu_pacing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace palp::test::gpu_pacing_test {
namespace {

constexpr std::int64_t kUs = 1'000, kMs = 1'000'000;

// A GPU and a server on it whose steps take so long of each millisecond. Its time goes by when someone works or sleeps.
class MadeUpGpu {
 public:
  explicit MadeUpGpu(std::int64_t step_ns) : step_ns_(step_ns), page_(std::make_shared<GpuPage>()) {
    if (step_ns > 0) server_ = take_place(*page_, 1, now_);
    tick(0);
  }

  GpuPacing::World world() {
    return {[this] { return now_; }, [this](std::int64_t ns) { tick(ns); }, [this] { ++finished; }};
  }
  std::shared_ptr<GpuPage> page() { return page_; }
  std::int64_t now() const { return now_; }

  // Lets time go by.
  void pass(std::int64_t ns) { tick(ns); }
  // Work of a viewer. Counts what a step had to wait for.
  void work(std::int64_t ns) {
    const std::int64_t begun = now_, last_ns = turned_ == begun_of(now_) ? 0 : kTurn;
    turned_ = begun_of(now_);
    tick(ns + last_ns);
    const std::int64_t due = begun_of(begun) + kMs - kTurnToServer;
    if (server_ != nullptr && (begun < begun_of(begun) + step_ns_ || now_ > due)) ++met;
  }

  int met = 0, finished = 0;  // pieces that a step met; waits for OpenGL

 private:
  static constexpr std::int64_t kTurn = 150 * kUs;
  static std::int64_t begun_of(std::int64_t t) { return t / kMs * kMs; }

  void tick(std::int64_t ns) {
    now_ += ns;
    if (server_ == nullptr) return;
    const std::int64_t begun = begun_of(now_);
    begin_step(*server_, begun);
    if (now_ >= begun + step_ns_) end_step(*server_, begun + step_ns_, begun + kMs);
  }

  std::int64_t step_ns_, now_ = 1'000 * kMs, turned_ = 0;
  std::shared_ptr<GpuPage> page_;
  GpuUse* server_ = nullptr;
};

// Draws a picture of parts that take so long, uneven by a quarter. Returns their numbers of pieces.
std::vector<int> draw(MadeUpGpu& gpu, GpuPacing& pacing, const std::vector<std::int64_t>& parts) {
  std::vector<int> pieces;
  pacing.begin_picture();
  for (const std::int64_t part : parts) {
    pacing.draw(64, [&](int k, int n) {
      if (k == 0) pieces.push_back(n);
      gpu.work(part / n * (k % 2 == 0 ? 5 : 3) / 4);
    });
  }
  return pieces;
}

TEST(GpuPacing, AloneOnAGpuAPictureIsDrawnAtOnce) {
  MadeUpGpu gpu(0);
  GpuPacing pacing(gpu.page(), gpu.world());
  for (int k = 0; k < 3; ++k) EXPECT_EQ(draw(gpu, pacing, {5 * kMs, kMs}), (std::vector<int>{1, 1}));
  EXPECT_EQ(pacing.waited_ns(), 0);
  EXPECT_EQ(gpu.finished, 0);
  EXPECT_FALSE(pacing.shared());
}

TEST(GpuPacing, NoPieceMeetsAStep) {
  for (const std::int64_t step : {50 * kUs, 200 * kUs, 350 * kUs, 450 * kUs}) {
    MadeUpGpu gpu(step);
    GpuPacing pacing(gpu.page(), gpu.world());
    for (int k = 0; k < 8; ++k) draw(gpu, pacing, {3 * kMs, 60 * kUs, 700 * kUs, 2 * kMs});
    const int met = gpu.met;
    const std::int64_t begun = gpu.now();
    for (int k = 0; k < 100; ++k) {
      draw(gpu, pacing, {3 * kMs, 60 * kUs, 700 * kUs, 2 * kMs});
      gpu.pass(k % 10 * 100 * kUs);  // so that pictures begin anywhere in a gap
    }
    EXPECT_EQ(gpu.met, met) << "steps of " << step << " ns";
    EXPECT_EQ(pacing.late_pieces(), 0u);
    EXPECT_TRUE(pacing.shared());
    // half of the time that no step and no turn takes is drawn in
    EXPECT_LT(gpu.now() - begun, 100 * 2 * 5760 * kUs * kMs / (kMs - step - 350 * kUs) + 45 * kMs)
        << "steps of " << step << " ns";
    EXPECT_GT(gpu.page()->drawn_ns, begun) << "servers are told";
  }
}

TEST(GpuPacing, PiecesAreAsManyAsTheWorkNeeds) {
  MadeUpGpu gpu(100 * kUs);
  GpuPacing pacing(gpu.page(), gpu.world());
  const auto usual = [&](std::int64_t part) {
    for (int k = 0; k < 12; ++k) draw(gpu, pacing, {part, 50 * kUs});
    const std::vector<int> pieces = draw(gpu, pacing, {part, 50 * kUs});
    EXPECT_EQ(pieces[1], 1);
    return pieces[0];
  };
  const int many = usual(2400 * kUs), few = usual(500 * kUs);
  EXPECT_GE(many, 11);  // gaps of 0.7 ms, of which a turn takes 0.15
  EXPECT_LE(many, 24);
  EXPECT_GE(few, 2);
  EXPECT_LE(few, 6);
  EXPECT_GE(usual(2400 * kUs), 11);
  EXPECT_GT(usual(20'000 * kUs), 60) << "at most 64";
}

TEST(GpuPacing, WithoutGapsPicturesComeSlowlyButTheyCome) {
  MadeUpGpu gpu(950 * kUs);
  GpuPacing pacing(gpu.page(), gpu.world());
  for (int k = 0; k < 10; ++k) draw(gpu, pacing, {3 * kMs, 2 * kMs});
  const std::int64_t begun = gpu.now();
  gpu.met = 0;
  for (int k = 0; k < 10; ++k) draw(gpu, pacing, {3 * kMs, 2 * kMs});
  const std::int64_t spent = gpu.now() - begun;
  EXPECT_LT(spent, 10 * 700 * kMs);
  EXPECT_GT(gpu.met, 0);
  EXPECT_LT(gpu.met, 0.3 * static_cast<double>(spent / kMs)) << "they leave most steps alone";
  EXPECT_GT(pacing.late_pieces(), 0u);
}

TEST(GpuPacing, WhatTakesLongOnceIsSoonForgotten) {
  MadeUpGpu gpu(200 * kUs);
  GpuPacing pacing(gpu.page(), gpu.world());
  for (int k = 0; k < 8; ++k) draw(gpu, pacing, {kMs, kMs});
  draw(gpu, pacing, {8 * kMs, kMs});
  for (int k = 0; k < 3; ++k) draw(gpu, pacing, {kMs, kMs});
  const std::int64_t begun = gpu.now();
  draw(gpu, pacing, {kMs, kMs});
  EXPECT_LT(gpu.now() - begun, 12 * kMs);
}

}  // namespace
}  // namespace palp::test::gpu_pacing_test
