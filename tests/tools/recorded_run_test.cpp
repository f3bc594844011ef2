// palp-run --record: a recording in simulated time, with the scene's hands.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "idl/cdr.h"
#include "idl/particle_frame.h"
#include "tests/support/process.h"
#include "tests/support/recordings.h"

namespace palp::test {
namespace {

class RecordedRun : public testing::Test {
 protected:
  // Runs crepe, which has hands for two devices.
  Outcome run(const std::string& file, const std::vector<std::string>& more = {}, const char* duration = "0.8") const {
    std::vector<std::string> command{std::string(PALP_BIN_DIR) + "/palp-run",
                                     "crepe",
                                     "--accuracy",
                                     "fast",
                                     "--backend",
                                     "cpu",
                                     "--duration",
                                     duration,
                                     "--record",
                                     file};
    command.insert(command.end(), more.begin(), more.end());
    return run_program(command);
  }
  template <class T>
  static std::vector<T> messages(const std::string& file) {
    std::vector<T> out;
    const std::map<std::string, std::vector<Bytes>> payloads = payloads_by_topic(file);
    for (const Bytes& payload : payloads.at(topic_of<T>().name))
      EXPECT_EQ(from_cdr(payload, out.emplace_back()), Fault::none);
    return out;
  }
  std::string file() const { return folder_ / "r.mcap"; }

  ScratchFolder folder_;
};

TEST_F(RecordedRun, HoldsWhatAServerSends) {
  const Outcome outcome = run(file());
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto scenes = messages<SceneDescription>(file());
  ASSERT_EQ(scenes.size(), 1u);
  EXPECT_EQ(scenes[0].name, "crepe");
  const auto chunks = messages<ParticleChunk>(file());
  // 60 a second, the initial state among them
  ASSERT_EQ(chunks.size(), 1 + 48u);
  EXPECT_EQ(chunks.front().sim_time, 0);
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    EXPECT_EQ(chunks[i].particle_count, scenes[0].particle_count);
    EXPECT_EQ(chunks[i].frame, i + 1);
    EXPECT_NEAR(chunks[i].sim_time, static_cast<double>(i) / 60, 1.001e-3) << i;
  }
  EXPECT_EQ(messages<BodyPoses>(file()).size(), chunks.size());
  EXPECT_EQ(messages<BodyPoses>(file()).front().pose.size(), 2u);
  EXPECT_EQ(messages<ProxySample>(file()).size(), 2 * 800u);
}

// The hand takes hold and leads the cup 12 cm to the side by 0.7 s; the pan's hand keeps still.
TEST_F(RecordedRun, HandsMoveTheTools) {
  ASSERT_EQ(run(file()).status, 0);
  const auto proxies = messages<ProxySample>(file());
  std::array<ProxySample, 2> first, last;
  for (const ProxySample& sample : proxies) {
    if (first.at(sample.device).sim_time == 0) first.at(sample.device) = sample;
    last.at(sample.device) = sample;
  }
  const auto way = [&](std::uint32_t device) {
    return last[device].proxy_pose.position[0] - first[device].proxy_pose.position[0];
  };
  EXPECT_NEAR(way(0), 0.12, 0.03);
  EXPECT_NEAR(way(1), 0, 0.01);
  // the bridge's loop gives the pan's weight, 8 N, to the arm, and a firm hand of 500 N/m yields by 16 mm
  const double start = messages<SceneDescription>(file()).at(0).proxies.at(1).pose.position[2];
  EXPECT_NEAR(last[1].device_pose.position[2] - start, -0.016, 0.006);
  for (const ProxySample& sample : last) {
    EXPECT_TRUE(sample.flags & kEngaged);
    EXPECT_GT(std::hypot(sample.wrench.force[0], sample.wrench.force[1], sample.wrench.force[2]), 0.1);
  }
}

TEST_F(RecordedRun, TheSameRunGivesTheSameBytes) {
  ASSERT_EQ(run(file()).status, 0);
  ASSERT_EQ(run(folder_ / "again.mcap").status, 0);
  EXPECT_TRUE(file_bytes(file()) == file_bytes(folder_ / "again.mcap"));
}

TEST_F(RecordedRun, TakesOtherHands) {
  ASSERT_EQ(run(file(), {"--hand", "0=still"}).status, 0);
  const auto proxies = messages<ProxySample>(file());
  double farthest = 0;
  for (const ProxySample& sample : proxies)
    if (sample.device == 0) farthest = std::max(farthest, std::abs(sample.proxy_pose.position[0] + 0.2));
  EXPECT_LT(farthest, 0.01);
}

TEST_F(RecordedRun, RefusesInOneSentence) {
  ASSERT_EQ(run(file(), {}, "0.01").status, 0);
  const std::vector<std::tuple<std::string, std::vector<std::string>, std::string>> cases{
      {file(), {}, "exists already"},
      {folder_ / "a.mcap", {"--hand", "waving"}, "waving"},
      {folder_ / "b.mcap", {"--hand", "5=still"}, "no [[proxy]] for device 5"},
      {"/no/such/folder/r.mcap", {}, "/no/such/folder/r.mcap"},
  };
  for (const auto& [to, more, expected] : cases) {
    const Outcome outcome = run(to, more, "0.01");
    EXPECT_NE(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find(expected), std::string::npos) << outcome.output;
  }
  EXPECT_EQ(run(file(), {"--overwrite"}, "0.01").status, 0);
}

}  // namespace
}  // namespace palp::test
