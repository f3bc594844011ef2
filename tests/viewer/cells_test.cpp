// Cells find what is near a place: the same as by looking at all places.
#include "viewer/cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "tests/support/random.h"

namespace palp::test::cells_test {
namespace {

class CellsTest : public RandomCase {
 protected:
  std::vector<float> places(std::size_t count, double width) {
    std::vector<float> all(3 * count);
    for (float& x : all) x = static_cast<float>(between(-width, width));
    return all;
  }
};

std::multiset<std::size_t> found(const Cells& cells, const Eigen::Vector3d& x) {
  std::multiset<std::size_t> all;
  cells.around(x, [&](std::size_t i) { all.insert(i); });
  return all;
}

TEST_F(CellsTest, WithinTheReachEachPlaceIsFoundOnce) {
  constexpr double kReach = 0.1;
  // the last one has more cells than there may be
  for (const double width : {0.01, 0.3, 2.0, 40.0}) {
    const std::vector<float> all = places(400, width);
    const Cells cells(all, kReach);
    for (int trial = 0; trial < 200; ++trial) {
      const Eigen::Vector3d x = 1.1 * width * Eigen::Vector3d(between(-1, 1), between(-1, 1), between(-1, 1));
      const auto near = found(cells, x);
      for (std::size_t i = 0; i < 400; ++i) {
        EXPECT_LE(near.count(i), 1u);
        if ((cells.place(i) - x).norm() < kReach) {
          EXPECT_EQ(near.count(i), 1u);
        }
      }
    }
  }
}

TEST_F(CellsTest, WhatIsNowhereIsNotFoundAndFindsNothing) {
  const double infinite = std::numeric_limits<double>::infinity(), none = std::nan("");
  std::vector<float> all = places(20, 0.01);
  all[4] = std::nanf("");
  all[9] = std::numeric_limits<float>::infinity();
  const Cells cells(all, 1);
  EXPECT_EQ(found(cells, {0, 0, 0}).size(), 18u);
  EXPECT_EQ(found(cells, {0, 0, 0}).count(1), 0u);
  for (const double far : {infinite, -infinite, 1e300, -1e300, none}) EXPECT_TRUE(found(cells, {0, far, 0}).empty());
  EXPECT_TRUE(found(Cells(), {0, 0, 0}).empty());
  EXPECT_TRUE(found(Cells({}, 1), {0, 0, 0}).empty());
  const std::vector<float> nowhere(3, std::nanf(""));
  EXPECT_TRUE(found(Cells(nowhere, 1), {0, 0, 0}).empty());
}

}  // namespace
}  // namespace palp::test::cells_test
