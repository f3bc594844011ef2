// The crepe of figures 1 and 2, as its two hands make it: poured, cooked, turned over, laid on a plate.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/support/played_scene.h"

namespace palp::test::crepe_scene_test {
namespace {

using Eigen::Vector3d;
using Indices = std::vector<std::size_t>;

class Crepe {
 public:
  Crepe() : played("crepe", {"crepe_cup", "crepe_pan"}), batter_(body_named(played.scene, "batter")) {}

  // Plays on, and looks at what the hands feel.
  void play(double until) {
    ASSERT_TRUE(played.play(until, [&](const StepOutput& out) {
      for (std::size_t hand : {0, 1}) {
        const ProxyOutput& p = out.proxies[hand];
        ASSERT_TRUE(p.contact_force.allFinite() && p.force.allFinite() && p.torque.allFinite()) << out.time;
        most[hand] = std::max(most[hand], p.contact_force.norm());
        load[hand] = p.contact_force.z();
      }
    }));
  }
  Indices all() const {
    Indices batter(batter_.count);
    std::iota(batter.begin(), batter.end(), batter_.first);
    return batter;
  }
  // The largest set whose particles are connected by steps of at most so many spacings.
  Indices largest_piece(double steps) const {
    const double reach = steps * played.scene.spacing;
    Indices left = all(), largest;
    while (!left.empty()) {
      Indices piece{left.back()};
      left.pop_back();
      for (std::size_t k = 0; k < piece.size(); ++k) {
        const Vector3d x = played.place(piece[k]);
        const auto near = std::partition(left.begin(), left.end(),
                                         [&](std::size_t j) { return (played.place(j) - x).norm() > reach; });
        piece.insert(piece.end(), near, left.end());
        left.erase(near, left.end());
      }
      if (piece.size() > largest.size()) largest = std::move(piece);
    }
    return largest;
  }
  double mean_height(const Indices& particles) const {
    double sum = 0;
    for (const std::size_t i : particles) sum += played.place(i).z();
    return sum / static_cast<double>(particles.size());
  }
  // Those of a piece that lie higher, or lower, by a third of a spacing than what is around them.
  Indices side(const Indices& piece, double sign) const {
    const double dx = played.scene.spacing;
    Indices found;
    for (const std::size_t i : piece) {
      const Vector3d x = played.place(i);
      Indices around;
      for (const std::size_t j : piece)
        if ((played.place(j) - x).head<2>().norm() < 2 * dx) around.push_back(j);
      if (sign * (x.z() - mean_height(around)) > 0.3 * dx) found.push_back(i);
    }
    return found;
  }

  PlayedScene played;
  std::array<double, 2> most{}, load{};  // on cup and pan, by contact: the largest, the last upwards [N]

 private:
  const Body& batter_;
};

void expect_on_the_plate(const Crepe& crepe, const Indices& piece) {
  const Vector3d plate = body_named(crepe.played.scene, "plate").position;
  double off = 0, high = -1, low = 1;
  for (const std::size_t i : piece) {
    const Vector3d x = crepe.played.place(i) - plate;
    off = std::max(off, x.head<2>().norm());
    high = std::max(high, x.z());
    low = std::min(low, x.z());
  }
  double lost = 0;
  for (const std::size_t i : crepe.all()) lost += crepe.played.place(i).z() < -0.05 ? 1 : 0;
  ::testing::Test::RecordProperty("particles_lost", std::to_string(lost));
  ::testing::Test::RecordProperty("off_the_plate's_middle_mm", std::to_string(1e3 * off));
  EXPECT_LT(off, 0.125) << "beyond the plate's rim";
  EXPECT_GT(low, -0.003) << "in the plate";
  EXPECT_LT(high, 0.07);
  EXPECT_LE(lost, 0.01 * static_cast<double>(crepe.all().size()))
      << "more than single drops splashed over the table's edge";
}

TEST(CrepeScene, IsPouredCookedTurnedAndLaidOnThePlate) {
  Crepe crepe;
  const Scene& scene = crepe.played.scene;
  const double weight = 9.81 * body_named(scene, "batter").mass, count = static_cast<double>(crepe.all().size());
  crepe.play(0.65);
  EXPECT_NEAR(crepe.load[0], -weight, 0.2 * weight) << "the cup's hand carries the batter";
  crepe.play(4.6);
  const Vector3d pan = crepe.played.simulation->output().bodies[scene.proxies[1].body].state.position;
  double in_pan = 0, solid = 0;
  for (const std::size_t i : crepe.all()) {
    const Vector3d x = crepe.played.place(i) - pan;
    in_pan += x.head<2>().norm() < 0.08 && std::abs(x.z()) < 0.06 ? 1 / count : 0;
    solid += static_cast<double>(crepe.played.snapshot.solid[i]) / count;
  }
  RecordProperty("share_in_pan", std::to_string(in_pan));
  RecordProperty("solid", std::to_string(solid));
  EXPECT_GT(in_pan, 0.95);
  EXPECT_GT(solid, 0.9) << "it is not cooked";
  EXPECT_NEAR(crepe.load[1], -weight, 0.2 * weight) << "the pan's hand carries the batter";
  const Indices piece = crepe.largest_piece(1.5), upper = crepe.side(piece, 1), lower = crepe.side(piece, -1);
  EXPECT_GT(static_cast<double>(piece.size()), 0.95 * count);
  ASSERT_GT(upper.size(), 20u);
  ASSERT_GT(lower.size(), 20u);
  const double before = crepe.mean_height(upper) - crepe.mean_height(lower);
  // out of the pan, in the air
  crepe.play(5.72);
  const Indices in_the_air = crepe.largest_piece(1.7);
  RecordProperty("piece_in_the_air", std::to_string(static_cast<double>(in_the_air.size()) / count));
  EXPECT_GT(static_cast<double>(in_the_air.size()), 0.95 * count) << "it falls apart";
  crepe.play(7.5);
  const double after = crepe.mean_height(upper) - crepe.mean_height(lower);
  RecordProperty("upper_above_lower_before_mm", std::to_string(1e3 * before));
  RecordProperty("upper_above_lower_after_mm", std::to_string(1e3 * after));
  EXPECT_GT(before, 0.8 * scene.spacing);
  EXPECT_LT(after, -0.4 * before) << "it is not turned over";
  EXPECT_GT(static_cast<double>(crepe.largest_piece(1.7).size()), 0.95 * count);
  expect_on_the_plate(crepe, piece);
  RecordProperty("cup_most_N", std::to_string(crepe.most[0]));
  RecordProperty("pan_most_N", std::to_string(crepe.most[1]));
  EXPECT_LT(crepe.most[0], 20);
  EXPECT_LT(crepe.most[1], 60);
}

}  // namespace
}  // namespace palp::test::crepe_scene_test
