// The page by which servers and viewers take turns on a GPU: what each side reads of what the other wrote, and of those
// that are silent, dead or several.
#include "idl/gpu_page.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>

namespace palp::test::gpu_page_test {
namespace {

constexpr std::int64_t kMs = 1'000'000, kStart = 5'000 * kMs;

class GpuPageTest : public testing::Test {
 protected:
  ~GpuPageTest() override { shm_unlink(("/palp-gpu-1-" + gpu_).c_str()); }
  GpuUse& server() { return *take_place(*page_, getpid(), kStart); }

  const std::string gpu_ = fmt::format("test{}", getpid());
  const std::shared_ptr<GpuPage> page_ = open_gpu_page(gpu_);
};

TEST_F(GpuPageTest, WithoutAServerTheGpuIsAlwaysFree) {
  EXPECT_EQ(gap_of(*page_, kStart).until_ns, kNever);
  EXPECT_EQ(gap_of(*page_, kStart).since_ns, 0);
  server();  // one that has not stepped yet, as it is still loading or paused
  EXPECT_EQ(gap_of(*page_, kStart).until_ns, kNever);
}

TEST_F(GpuPageTest, TheGapLastsFromAStepUntilTheGpuTurnsToTheNext) {
  GpuUse& steps = server();
  begin_step(steps, kStart);
  EXPECT_EQ(gap_of(*page_, kStart).until_ns, 0) << "a step runs";
  end_step(steps, kStart + kMs / 2, kStart + kMs);
  EXPECT_EQ(gap_of(*page_, kStart + kMs / 2).since_ns, kStart + kMs / 2);
  EXPECT_EQ(gap_of(*page_, kStart + kMs / 2).until_ns, kStart + kMs - kTurnToServer);
  begin_step(steps, kStart + kMs);
  EXPECT_EQ(gap_of(*page_, kStart + kMs).until_ns, 0) << "the next step runs";
}

TEST_F(GpuPageTest, AServerThatIsLateOrNeverWaitsLeavesNoGap) {
  GpuUse& steps = server();
  begin_step(steps, kStart);
  end_step(steps, kStart + 2 * kMs, kStart + kMs);
  EXPECT_LT(gap_of(*page_, kStart + 2 * kMs).until_ns, kStart + 2 * kMs);
}

TEST_F(GpuPageTest, WhoIsSilentCountsNoLonger) {
  GpuUse& steps = server();
  begin_step(steps, kStart);  // and is killed, or paused after this step
  EXPECT_EQ(gap_of(*page_, kStart + kGpuSilence).until_ns, 0);
  EXPECT_EQ(gap_of(*page_, kStart + kGpuSilence + 1).until_ns, kNever);
  end_step(steps, kStart + kGpuSilence + kMs, kStart + kGpuSilence + 2 * kMs);
  EXPECT_NE(gap_of(*page_, kStart + kGpuSilence + kMs).until_ns, kNever) << "it is back";
}

TEST_F(GpuPageTest, AGapIsWhereNoServerNeedsTheGpu) {
  GpuUse &one = server(), &other = server();
  ASSERT_NE(&one, &other);
  for (GpuUse* each : {&one, &other}) begin_step(*each, kStart);
  end_step(one, kStart + 2 * kMs, kStart + 9 * kMs);
  EXPECT_EQ(gap_of(*page_, kStart + 2 * kMs).until_ns, 0) << "the other one's step runs";
  end_step(other, kStart + 3 * kMs, kStart + 5 * kMs);
  EXPECT_EQ(gap_of(*page_, kStart + 3 * kMs).since_ns, kStart + 3 * kMs);
  EXPECT_EQ(gap_of(*page_, kStart + 3 * kMs).until_ns, kStart + 5 * kMs - kTurnToServer);
  leave_place(other);
  EXPECT_EQ(gap_of(*page_, kStart + 3 * kMs).until_ns, kStart + 9 * kMs - kTurnToServer);
}

TEST_F(GpuPageTest, ThereIsRoomForFourServersAndForThoseWhoComeAfterADeadOne) {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  GpuUse* dead = take_place(*page_, child, kStart);
  begin_step(*dead, kStart);
  for (int k = 0; k < 3; ++k) ASSERT_NE(take_place(*page_, getpid(), kStart), nullptr);
  EXPECT_EQ(take_place(*page_, getpid(), kStart + kMs), nullptr) << "it may live in a container whose ids differ";
  EXPECT_EQ(take_place(*page_, getpid(), kStart + kGpuSilence + kMs), dead);
  EXPECT_EQ(take_place(*page_, getpid(), kStart + 10 * kGpuSilence), nullptr) << "paused ones keep their places";
}

TEST_F(GpuPageTest, AGpuIsInUseWhileAServerLives) {
  EXPECT_FALSE(in_use(*page_, kStart));
  GpuUse& place = server();
  EXPECT_TRUE(in_use(*page_, kStart)) << "it has not stepped yet";
  begin_step(place, kStart);
  EXPECT_TRUE(in_use(*page_, kStart + 10 * kGpuSilence)) << "a paused one goes on";
  leave_place(place);
  EXPECT_FALSE(in_use(*page_, kStart));
  const pid_t child = fork();
  if (child == 0) _exit(0);
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  begin_step(*take_place(*page_, child, kStart), kStart);
  EXPECT_FALSE(in_use(*page_, kStart + kGpuSilence + kMs)) << "it is dead";
}

TEST_F(GpuPageTest, TwoProcessesSeeOnePage) {
  const pid_t child = fork();
  if (child == 0) {
    const std::shared_ptr<GpuPage> page = open_gpu_page(gpu_);
    GpuUse* steps = take_place(*page, getpid(), kStart);
    begin_step(*steps, kStart);
    end_step(*steps, kStart + kMs / 4, kStart + kMs);
    _exit(page->drawn_ns == 7 ? 0 : 1);
  }
  page_->drawn_ns = 7;
  int status = 1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(gap_of(*page_, kStart + kMs / 2).until_ns, kStart + kMs - kTurnToServer);
}

TEST(GpuPage, SaysWhyItCannotBeHad) {
  try {
    open_gpu_page("no/name");
    FAIL() << "a name with a slash was opened";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("cannot take turns"), std::string::npos) << error.what();
  }
}

TEST(GpuPage, AnIdentityIsSixteenBytesOrNone) {
  std::array<unsigned char, 16> uuid{};
  EXPECT_EQ(gpu_identity(uuid.data()), "");
  uuid[0] = 0x1f;
  uuid[15] = 0xa0;
  EXPECT_EQ(gpu_identity(uuid.data()), "1f0000000000000000000000000000a0");
}

}  // namespace
}  // namespace palp::test::gpu_page_test
