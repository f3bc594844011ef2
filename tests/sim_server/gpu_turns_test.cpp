// The words of a server in the page of its GPU, and when it takes the GPU back from viewers.
#include "sim_server/gpu_turns.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "idl/clock.h"

namespace palp::test::gpu_turns_test {
namespace {

// Computes nothing, on a GPU of that name.
class OnGpu : public Simulation {
 public:
  explicit OnGpu(std::string gpu) : gpu_(std::move(gpu)) {}
  std::string gpu() const override { return gpu_; }
  void take_gpu() override { ++taken; }
  const Scene& scene() const override { return scene_; }
  std::string backend_name() const override { return {}; }
  std::string numerics() const override { return {}; }
  double support_radius() const override { return 0; }
  int sub_steps() const override { return 1; }
  int fluid_interval() const override { return 1; }
  const StepOutput& step(const StepInput& /*input*/) override { return output_; }
  const StepOutput& output() const override { return output_; }
  void reset() override {}
  void set_parameter(const std::string& /*name*/, const std::string& /*value*/) override {}
  void snapshot(Snapshot& /*out*/) override {}
  bool begin_frame(ScalarField /*scalar*/) override { return false; }
  bool take_frame(Frame& /*out*/) override { return false; }
  Footprint footprint() const override { return {}; }
  StageTimes time_stages(const StepInput& /*input*/, double /*seconds*/) override { return {}; }
  const std::vector<std::string>& warnings() const override { return warnings_; }

  int taken = 0;

 private:
  std::string gpu_;
  Scene scene_;
  StepOutput output_;
  std::vector<std::string> warnings_;
};

class GpuTurnsTest : public testing::Test {
 protected:
  ~GpuTurnsTest() override { shm_unlink(("/palp-gpu-1-" + gpu_).c_str()); }

  const std::string gpu_ = fmt::format("turns{}", getpid());
  OnGpu simulation_{gpu_};
  const std::shared_ptr<GpuPage> page_ = open_gpu_page(gpu_);  // as a viewer has it
};

TEST_F(GpuTurnsTest, ViewersSeeWhenStepsRun) {
  const std::int64_t now = now_ns();
  {
    GpuTurns turns(simulation_);
    turns.begin_step(now);
    EXPECT_EQ(gap_of(*page_, now).until_ns, 0);
    turns.end_step(now + 1000, now + 1'000'000);
    EXPECT_EQ(gap_of(*page_, now + 1000).until_ns, now + 1'000'000 - kTurnToServer);
  }
  EXPECT_EQ(gap_of(*page_, now + 1000).until_ns, kNever) << "it has ended";
}

TEST_F(GpuTurnsTest, TheGpuIsTakenBackFromWhoHasDrawnSinceTheLastStep) {
  GpuTurns turns(simulation_);
  const std::int64_t now = now_ns();
  EXPECT_FALSE(turns.viewer_draws(now));
  turns.begin_step(now);
  turns.take_back();
  EXPECT_EQ(simulation_.taken, 0) << "nobody has drawn";
  page_->drawn_ns = now + 1000;
  turns.take_back();
  EXPECT_EQ(simulation_.taken, 1);
  EXPECT_TRUE(turns.viewer_draws(now + 1000));
  turns.begin_step(now + 1'000'000);
  turns.take_back();
  EXPECT_EQ(simulation_.taken, 1) << "nobody has drawn since this step began";
  EXPECT_FALSE(turns.viewer_draws(now + 2'000'000'000)) << "it has ended";
}

TEST_F(GpuTurnsTest, OnACpuThereIsNothingToShare) {
  OnGpu cpu("");
  GpuTurns turns(cpu);
  turns.begin_step(now_ns());
  turns.take_back();
  turns.end_step(now_ns(), now_ns());
  EXPECT_FALSE(turns.viewer_draws(now_ns()));
  EXPECT_EQ(cpu.taken, 0);
}

TEST_F(GpuTurnsTest, WithoutAPageItGoesOn) {
  OnGpu unnameable("a/b");
  GpuTurns turns(unnameable);
  turns.begin_step(now_ns());
  turns.take_back();
  turns.end_step(now_ns(), now_ns());
  EXPECT_EQ(unnameable.taken, 0);
}

}  // namespace
}  // namespace palp::test::gpu_turns_test
