// The order of drawing: every place once, by layers along the way of looking.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/random.h"
#include "viewer/front_to_back.h"

namespace palp::test::front_to_back_test {
namespace {

class FrontToBackOrder : public RandomCase {
 protected:
  std::vector<osg::Vec4f> places(std::size_t count) {
    std::vector<osg::Vec4f> all;
    for (std::size_t i = 0; i < count; ++i)
      all.emplace_back(static_cast<float>(between(2, 3)), static_cast<float>(between(-1, 1)),
                       static_cast<float>(between(0, 0.5)), 0.0f);
    return all;
  }
};

// Returns which place comes k-th, and expects that each comes once.
std::vector<std::size_t> order_of(const std::vector<osg::Vec4f>& places, const osg::Vec3f& along) {
  FrontToBack front_to_back;
  const auto ranks = front_to_back.rank(places, along);
  EXPECT_EQ(ranks.size(), places.size());
  std::vector<std::size_t> order(places.size(), places.size());
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    if (ranks[i] < order.size()) order[ranks[i]] = i;
  }
  EXPECT_EQ(std::ranges::count(order, places.size()), 0) << "places without a rank of their own";
  return order;
}

TEST_F(FrontToBackOrder, WhatIsNearComesFirst) {
  const std::vector<osg::Vec4f> all = places(2000);
  for (const osg::Vec3d& eye : {osg::Vec3d(0, 0, 1), osg::Vec3d(9, -7, 3), osg::Vec3d(2.5, 0, -4)}) {
    osg::Vec3d along = osg::Vec3d(2.5, 0, 0.25) - eye;
    along.normalize();
    const std::vector<std::size_t> order = order_of(all, osg::Vec3f(along));
    const auto way = [&](std::size_t k) {
      const osg::Vec4f& p = all[order[k]];
      return osg::Vec3d(p.x(), p.y(), p.z()) * along;
    };
    double farthest = way(0);
    for (std::size_t k = 1; k < order.size(); ++k) {
      EXPECT_GT(way(k), farthest - 0.02) << "layers are some millimetres thick, and the middle is one of random places";
      farthest = std::max(farthest, way(k));
    }
    EXPECT_GT(farthest, way(0) + 0.4);
  }
}

TEST_F(FrontToBackOrder, OfOneLayerKeepsTheirOrder) {
  const std::vector<osg::Vec4f> alike(50, osg::Vec4f(1, 2, 3, 4));
  const std::vector<std::size_t> order = order_of(alike, {0, 0, 1});
  EXPECT_TRUE(std::ranges::is_sorted(order));
}

TEST_F(FrontToBackOrder, NoDirectionOrNoPlacesAreNoFault) {
  order_of(places(300), {0, 0, 0});
  order_of(places(1), {0, 0, 1});
  FrontToBack front_to_back;
  front_to_back.rank(places(3), {0, 0, 1});
  EXPECT_TRUE(front_to_back.box().valid());
  EXPECT_TRUE(front_to_back.rank({}, {0, 0, 1}).empty());
  EXPECT_FALSE(front_to_back.box().valid());
}

}  // namespace
}  // namespace palp::test::front_to_back_test
