// The kitchen of figure 7, as its hand plays it: stirring the juice, then a tap on the custard.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/played_scene.h"

namespace palp::test::kitchen_scene_test {
namespace {

using Eigen::Vector3d;

// Mean height of a body's upper layer of particles at the start [m].
double top_height(const PlayedScene& played, const Body& body) {
  double top = -1e30, sum = 0;
  int count = 0;
  const auto last = body.first + body.count;
  for (std::size_t i = body.first; i < last; ++i) top = std::max(top, played.scene.position[i].z());
  for (std::size_t i = body.first; i < last; ++i) {
    if (played.scene.position[i].z() < top - 0.5 * played.scene.spacing) continue;
    sum += played.place(i).z();
    ++count;
  }
  return sum / count;
}

// The custard and the juice are still, and the juice is in its glass.
void expect_at_rest(const PlayedScene& played) {
  const Scene& scene = played.scene;
  const Body &juice = body_named(scene, "juice"), &custard = body_named(scene, "custard");
  const Body& glass = body_named(scene, "glass");
  double fastest = 0, custard_speed = 0;
  int outside = 0, lost = 0;
  for (std::size_t i = custard.first; i < custard.first + custard.count; ++i)
    custard_speed = std::max(custard_speed, played.speed(i));
  for (std::size_t i = juice.first; i < juice.first + juice.count; ++i) {
    const Vector3d x = played.place(i) - glass.position;
    outside += std::hypot(x.x(), x.y()) > 0.06 + 0.1 * scene.spacing || x.z() < 0.02;
    lost += x.z() < -0.02 || x.head<2>().norm() > 0.4;
    fastest = std::max(fastest, played.speed(i));
  }
  ::testing::Test::RecordProperty("custard_speed_at_end", std::to_string(custard_speed));
  ::testing::Test::RecordProperty("juice_speed_at_end", std::to_string(fastest));
  ::testing::Test::RecordProperty("juice_particles_outside", outside);
  EXPECT_LT(custard_speed, 0.01);
  EXPECT_LT(fastest, 0.03);
  EXPECT_EQ(lost, 0);
  EXPECT_LE(outside, 0.01 * juice.count) << "more than the drops that the spoon carries away";
}

TEST(Kitchen, JuiceDragsTheSpoonAndTheCustardWobbles) {
  PlayedScene played("kitchen", {"kitchen"});
  const Scene& scene = played.scene;
  const Body& custard = body_named(scene, "custard");
  double work = 0, way = 0, most = 0;
  const auto stirring = [&](const StepOutput& out) {
    const Vector3d f = out.proxies[0].contact_force, v = out.proxies[0].state.linear;
    ASSERT_TRUE(f.allFinite() && out.proxies[0].force.allFinite() && out.proxies[0].torque.allFinite());
    most = std::max(most, f.norm());
    if (out.time < 2.2) return;
    work -= f.dot(v) / scene.config.rate_hz;
    way += v.norm() / scene.config.rate_hz;
  };
  ASSERT_TRUE(played.play(4.1, stirring));
  RecordProperty("drag_N", std::to_string(work / way));
  RecordProperty("most_while_stirring_N", std::to_string(most));
  EXPECT_GT(work / way, 0.3) << "thick juice is felt";
  EXPECT_LT(work / way, 2);
  EXPECT_LT(most, 5);
  ASSERT_TRUE(played.play(6.4));
  const double rest = top_height(played, custard);
  double push = 0, deepest = rest, highest = 0;
  const auto tap = [&](const StepOutput& out) { push = std::max(push, out.proxies[0].contact_force.z()); };
  int swings = 0;
  double side = -1;
  for (double t = 6.41; t < 8.005; t += 0.01) {
    ASSERT_TRUE(played.play(t, tap));
    const double off = top_height(played, custard) - rest;
    deepest = std::min(deepest, rest + off);
    if (t < 6.95) continue;
    highest = std::max(highest, off);
    if (off * side < 0 && std::abs(off) > 2e-5) {
      ++swings;
      side = -side;
    }
  }
  RecordProperty("tap_N", std::to_string(push));
  RecordProperty("dent_mm", std::to_string(1e3 * (rest - deepest)));
  RecordProperty("overshoot_mm", std::to_string(1e3 * highest));
  RecordProperty("swings", swings);
  EXPECT_GT(push, 0.5);
  EXPECT_LT(push, 20);
  EXPECT_GT(rest - deepest, 1e-3);
  EXPECT_GE(swings, 2) << "it does not wobble";
  EXPECT_NEAR(top_height(played, custard), rest, 1e-4) << "it does not come back";
  expect_at_rest(played);
}

}  // namespace
}  // namespace palp::test::kitchen_scene_test
