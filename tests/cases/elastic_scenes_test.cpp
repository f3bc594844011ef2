// The scenes in which a hand changes an elastic body for good, with the paths of their hands.
#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scene_files.h"

namespace palp::test::elastic_scenes_test {
namespace {

using Eigen::Vector3d;

// A hand that moves the tool up and down.
class HandScene {
 public:
  explicit HandScene(const std::string& name) : scene(scene_file(name)), simulation(simulate(scene)) {
    const Proxy& proxy = scene.proxies[0];
    const Body& tool = scene.bodies[proxy.body];
    start_ = tool.position + tool.orientation * proxy.handle;
    input_[0].engaged = true;
    input_[0].gains = proxy.limit;
  }
  // To a height above the start, at the path's constant speed. Returns the largest push up on the tool [N].
  double move(double to, double time) {
    const int steps = static_cast<int>(time * scene.config.rate_hz);
    const double from = at_;
    double most = 0;
    for (int k = 1; k <= steps; ++k) {
      at_ = from + (to - from) * k / steps;
      input_[0].state.position = start_ + Vector3d(0, 0, at_);
      const StepOutput& out = simulation->step(input_);
      if (!out.health.ok) {
        ADD_FAILURE() << out.health.cause << " after " << out.time << " s";
        return most;
      }
      most = std::max(most, out.proxies[0].contact_force.z());
    }
    return most;
  }
  // Returns the mean height of a body's particles that were within a distance of the axis and above a height at the
  // start.
  double mean_height(const Body& body, double within, double above) {
    simulation->snapshot(snapshot);
    double sum = 0;
    int count = 0;
    for (std::size_t i = body.first; i < body.first + body.count; ++i) {
      if (scene.position[i].head<2>().norm() > within || scene.position[i].z() < above) continue;
      sum += snapshot.position[3 * i + 2];
      ++count;
    }
    return sum / count;
  }

  Scene scene;
  std::unique_ptr<Simulation> simulation;
  Snapshot snapshot;

 private:
  StepInput input_;
  Vector3d start_;
  double at_ = 0;
};

TEST(Dough, KeepsTheDent) {
  HandScene hand("dough");
  const Body& dough = body_named(hand.scene, "dough");
  const double dx = hand.scene.spacing, top = 0.09 - dx;
  const double flat = hand.mean_height(dough, 0.02, top);
  hand.move(0, 0.05);
  const double push = hand.move(-0.09, 0.8);
  EXPECT_GT(push, 3) << "the hand feels it";
  const double pressed = flat - hand.mean_height(dough, 0.02, top);
  EXPECT_GT(pressed, 0.02);
  hand.move(0, 0.6);
  EXPECT_EQ(hand.move(0, 0.05), 0) << "the tool has left";
  const double stays = flat - hand.mean_height(dough, 0.02, top);
  hand.move(0, 0.3);
  const double later = flat - hand.mean_height(dough, 0.02, top);
  RecordProperty("push_N", std::to_string(push));
  RecordProperty("pressed_mm", std::to_string(1e3 * pressed));
  RecordProperty("stays_mm", std::to_string(1e3 * stays));
  RecordProperty("later_mm", std::to_string(1e3 * later));
  EXPECT_GT(stays, 0.6 * pressed);
  EXPECT_LT(stays, 1.02 * pressed);
  EXPECT_NEAR(later, stays, 0.02 * pressed) << "it creeps";
}

TEST(JellySheet, RipsAndLetsTheStickThrough) {
  HandScene hand("jelly_sheet");
  const Body& sheet = body_named(hand.scene, "sheet");
  hand.move(0, 0.05);
  // a third of the way down it only gives, and springs back
  const double first = hand.move(-0.06, 0.5);
  EXPECT_GT(first, 1);
  const double held = hand.move(-0.06, 0.1);
  EXPECT_GT(held, 0.5 * first);
  const double peak = std::max(first, hand.move(-0.2, 0.8));
  hand.move(-0.2, 0.3);
  const double through = hand.move(-0.2, 0.1);
  RecordProperty("first_N", std::to_string(first));
  RecordProperty("peak_N", std::to_string(peak));
  RecordProperty("through_N", std::to_string(through));
  EXPECT_LT(through, 0.25 * peak) << "it is through";
  hand.simulation->snapshot(hand.snapshot);
  // the stick's lower end is well below the sheet, and the sheet where the frame holds it
  const Body& stick = hand.scene.bodies[hand.scene.proxies[0].body];
  const RigidState& now = hand.simulation->output().bodies[hand.scene.proxies[0].body].state;
  double low = 1;
  for (int c = 0; c < 8; ++c) {
    const auto which = static_cast<Eigen::AlignedBox3d::CornerType>(c);
    const Vector3d corner = stick.extent.corner(which) - stick.orientation.conjugate() * stick.position;
    low = std::min(low, (now.position + now.orientation * corner).z());
  }
  EXPECT_LT(low, -0.1);
  int near = 0, below = 0;
  for (std::size_t i = sheet.first; i < sheet.first + sheet.count; ++i) {
    near += hand.scene.position[i].head<2>().norm() > 0.08;
    below += hand.scene.position[i].head<2>().norm() > 0.08 && hand.snapshot.position[3 * i + 2] < -0.06;
  }
  EXPECT_LT(below, 0.05 * near);
  // drawn out again
  hand.move(0, 0.8);
  hand.move(0, 0.1);
  EXPECT_LT(hand.move(0, 0.1), 0.1 * peak);
}

}  // namespace
}  // namespace palp::test::elastic_scenes_test
