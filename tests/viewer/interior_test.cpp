// Which particles of a body are within it: against distances and cells counted one by one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/random.h"
#include "viewer/interior.h"

namespace palp::test::interior_test {
namespace {

using Places = std::vector<osg::Vec4f>;

constexpr int kSide = 16;
constexpr float kSpacing = 0.01f;

// A cube of a lattice, from layer to layer; each place moves by up to so many spacings along each axis.
template <class Move>
Places cube(Move&& move, int side = kSide) {
  Places places;
  for (int i = 0; i < side * side * side; ++i) {
    const int at[3] = {i % side, i / side % side, i / (side * side)};
    osg::Vec4f place;
    for (int a = 0; a < 3; ++a) place[a] = kSpacing * static_cast<float>(at[a] + move());
    places.push_back(place);
  }
  return places;
}

// Layers between a place of the cube and its nearest side.
int layers_over(int i, int side) {
  int least = side;
  for (const int at : {i % side, i / side % side, i / (side * side)}) least = std::min({least, at, side - 1 - at});
  return least;
}

std::vector<bool> within(const Places& places, double spacing = kSpacing) {
  Interior interior;
  interior.find(places, spacing);
  std::vector<bool> all;
  for (std::size_t i = 0; i < places.size(); ++i) all.push_back(interior.contains(i));
  return all;
}

// The larger cube is worth several threads.
TEST(Interior, IsWhatLayersCover) {
  for (const int side : {kSide, 64}) {
    const std::vector<bool> inner = within(cube([] { return 0.0; }, side));
    for (int i = 0; i < side * side * side; ++i) {
      const int layers = layers_over(i, side);
      if (layers < 2) {
        ASSERT_FALSE(inner[i]) << i << " is covered by " << layers << " layers";
      }
      if (layers >= 5) {
        ASSERT_TRUE(inner[i]) << i;
      }
    }
  }
}

class DisturbedInterior : public RandomCase {};

// Nothing that is within is nearer than three spacings to a cell without particles, as there is one in a hole of this
// size, nor than one and a half to the outermost particles.
TEST_F(DisturbedInterior, KeepsAwayFromOutsideAndHoles) {
  Places places = cube([&] { return between(-0.2, 0.2); });
  const int center = kSide / 2 * (1 + kSide + kSide * kSide);
  const osg::Vec4f hole = places[center];
  const auto distance = [&](const osg::Vec4f& p) {
    return std::hypot(p.x() - hole.x(), p.y() - hole.y(), p.z() - hole.z());
  };
  std::erase_if(places, [&](const osg::Vec4f& p) { return distance(p) < 2.7 * kSpacing; });
  const std::vector<bool> inner = within(places);
  int count = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!inner[i]) continue;
    ++count;
    EXPECT_GT(distance(places[i]), 3 * kSpacing);
    for (int a = 0; a < 3; ++a) {
      EXPECT_GT(places[i][a], 1.3 * kSpacing);
      EXPECT_LT(places[i][a], (kSide - 1 - 1.3) * kSpacing);
    }
  }
  EXPECT_GT(count, 50) << "most of the inner layers";
}

// Lumps stand for what is within: as many particles, about the same middle, each within a lump's reach of its own.
TEST_F(DisturbedInterior, IsLumpedWithoutLoss) {
  const Places places = cube([&] { return between(-0.3, 0.3); });
  Interior interior;
  interior.find(places, kSpacing);
  osg::ref_ptr<osg::Vec4Array> lumps = new osg::Vec4Array;
  interior.add_lumps(places, *lumps);
  osg::Vec3d middle, middle_of_lumps;
  double count = 0, count_of_lumps = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!interior.contains(i)) continue;
    const osg::Vec3d place(places[i].x(), places[i].y(), places[i].z());
    middle += place;
    ++count;
    const bool near = std::ranges::any_of(*lumps, [&](const osg::Vec4f& lump) {
      return (osg::Vec3d(lump.x(), lump.y(), lump.z()) - place).length() <
             std::sqrt(3.0) * Interior::kLumpOverSpacing * kSpacing;
    });
    EXPECT_TRUE(near) << i;
  }
  for (const osg::Vec4f& lump : *lumps) {
    EXPECT_LT(lump.w(), 3) << "eight of a lattice fit where they are pressed together, 3.4 fill it";
    middle_of_lumps += osg::Vec3d(lump.x(), lump.y(), lump.z()) * (lump.w() * Interior::kParticlesOfLump);
    count_of_lumps += lump.w() * Interior::kParticlesOfLump;
  }
  ASSERT_GT(count, 0);
  EXPECT_LT(static_cast<double>(lumps->size()), count / 2);
  EXPECT_NEAR(count_of_lumps, count, 1e-3);
  EXPECT_LT((middle / count - middle_of_lumps / count).length(), 1e-3 * kSpacing);
}

TEST_F(DisturbedInterior, IsTheSameWhereverTheBodyIs) {
  Places places = cube([&] { return between(-0.2, 0.2); });
  const std::vector<bool> here = within(places);
  const osg::Vec4f far(8, -4, 2, 0);  // halves of floats: the lattice is the same there
  for (osg::Vec4f& p : places) p += far;
  const std::vector<bool> there = within(places);
  int different = 0;
  for (std::size_t i = 0; i < here.size(); ++i) different += here[i] != there[i] ? 1 : 0;
  EXPECT_LT(different, 0.02 * static_cast<double>(here.size())) << "places are rounded there";
}

TEST(Interior, IsNothingWhereItCannotBeFound) {
  const Places places = cube([] { return 0.0; });
  for (const double spacing : {0.0, -0.01, std::numeric_limits<double>::quiet_NaN()})
    for (const bool inner : within(places, spacing)) ASSERT_FALSE(inner) << spacing;
  for (const bool inner : within({}, kSpacing)) ASSERT_FALSE(inner);
  for (const bool inner : within(Places(1000, osg::Vec4f(1, 2, 3, 0)), kSpacing)) ASSERT_FALSE(inner);
}

// One particle far away makes cells larger, not memory.
TEST(Interior, BearsParticlesThatAreFarAway) {
  for (const osg::Vec4f far :
       {osg::Vec4f(9e4f, 0, 0, 0), osg::Vec4f(0, -9e4f, 9e4f, 0), osg::Vec4f(9e4f, 9e4f, -9e4f, 0)}) {
    Places places = cube([] { return 0.0; });
    places.push_back(far);
    const std::vector<bool> inner = within(places);
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
      if (layers_over(i, kSide) < 2) {
        ASSERT_FALSE(inner[i]) << i;
      }
    }
    EXPECT_FALSE(inner.back());
  }
}

}  // namespace
}  // namespace palp::test::interior_test
