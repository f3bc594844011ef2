// Surfaces that particles carry along: against places that are known, and where matter is torn.
#include "viewer/skin.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "tests/support/random.h"
#include "viewer/refine.h"

namespace palp::test::skin_test {
namespace {

constexpr double kSpacing = 0.01;

// The middles of the cells of a block whose corner is at the origin.
std::vector<float> block(const std::array<int, 3>& sides) {
  std::vector<float> places;
  for (int k = 0; k < sides[2]; ++k)
    for (int j = 0; j < sides[1]; ++j)
      for (int i = 0; i < sides[0]; ++i)
        for (const int n : {i, j, k}) places.push_back(static_cast<float>(kSpacing * (n + 0.5)));
  return places;
}

// A box from the origin to here, of two triangles a side.
Surface box(const osg::Vec3f& to) {
  Surface surface;
  for (unsigned v = 0; v < 8; ++v)
    surface.vertices.emplace_back(v & 1 ? to.x() : 0, v & 2 ? to.y() : 0, v & 4 ? to.z() : 0);
  for (const auto& q : {std::array{0u, 2u, 3u, 1u},
                        {4u, 5u, 7u, 6u},
                        {0u, 1u, 5u, 4u},
                        {2u, 6u, 7u, 3u},
                        {0u, 4u, 6u, 2u},
                        {1u, 3u, 7u, 5u}})
    for (const auto& corner : {std::array{q[0], q[1], q[2]}, {q[0], q[2], q[3]}}) {
      surface.triangles.push_back({corner, {}, 0, -1});
      measure(surface, surface.triangles.back());
    }
  return surface;
}

double area_of(const Surface& surface) {
  double area = 0;
  for (const Triangle& t : surface.triangles) area += t.area;
  return area;
}

TEST(Refine, HalvesEdgesAndLeavesTheSurfaceWhereItIs) {
  Surface surface = box({0.1f, 0.07f, 0.031f});
  const double before = area_of(surface);
  refine(surface, kSpacing);
  EXPECT_NEAR(area_of(surface), before, 1e-6 * before);
  std::multiset<std::pair<unsigned, unsigned>> edges;
  for (const Triangle& t : surface.triangles) {
    const osg::Vec3f& a = surface.vertices[t.corner[0]];
    EXPECT_GT(((surface.vertices[t.corner[1]] - a) ^ (surface.vertices[t.corner[2]] - a)) * t.normal, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const unsigned from = t.corner[k], to = t.corner[(k + 1) % 3];
      EXPECT_LE((surface.vertices[to] - surface.vertices[from]).length(), 1.0001 * kSpacing);
      edges.emplace(from, to);
    }
  }
  for (const auto& [from, to] : edges) {
    EXPECT_EQ(edges.count({from, to}), 1u) << "of two triangles on one side";
    EXPECT_EQ(edges.count({to, from}), 1u) << "a gap";
  }
}

class RandomSkin : public RandomCase {};

TEST_F(RandomSkin, FollowsWhatIsAffineExactly) {
  const std::vector<float> rest = block({8, 5, 3});
  Surface surface = box({0.08f, 0.05f, 0.03f});
  refine(surface, kSpacing);
  auto skin = Skin::bind(surface.vertices, rest, kSpacing);
  ASSERT_TRUE(skin);
  for (int run = 0; run < 20; ++run) {
    const Eigen::Matrix3d A = rotation() + matrix(0.3);
    const Eigen::Vector3d shift = vector(0.2);
    const auto moved = [&](double x, double y, double z) {
      return Eigen::Vector3d(A * Eigen::Vector3d(x, y, z) + shift);
    };
    std::vector<float> places;
    for (std::size_t i = 0; i < rest.size(); i += 3)
      for (const double x : moved(rest[i], rest[i + 1], rest[i + 2])) places.push_back(static_cast<float>(x));
    std::vector<osg::Vec3f> vertices(skin->vertices());
    skin->carry(places, vertices);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const osg::Vec3f& X = surface.vertices[v];
      const Eigen::Vector3d wanted = moved(X.x(), X.y(), X.z());
      for (int a = 0; a < 3; ++a) EXPECT_NEAR(vertices[v][a], wanted[a], 1e-3 * kSpacing);
    }
  }
}

TEST(Skin, IsNotBoundWhereParticlesLieInAPlane) {
  const std::vector<osg::Vec3f> vertices{{0.03f, 0.03f, 0.01f}};
  EXPECT_FALSE(Skin::bind(vertices, block({6, 6, 1}), kSpacing));
  EXPECT_TRUE(Skin::bind(vertices, block({6, 6, 2}), kSpacing));
  EXPECT_FALSE(Skin::bind(std::vector<osg::Vec3f>{{1, 1, 1}}, block({6, 6, 2}), kSpacing)) << "far from all particles";
  EXPECT_FALSE(Skin::bind(vertices, {}, kSpacing));
}

TEST(Skin, EndsBesideATearAndLeavesTheRest) {
  constexpr int kLong = 24, kCut = 12;
  const std::vector<float> rest = block({kLong, 4, 4});
  Surface surface = box({0.24f, 0.04f, 0.04f});
  refine(surface, kSpacing);
  auto skin = Skin::bind(surface.vertices, rest, kSpacing);
  ASSERT_TRUE(skin);
  EXPECT_TRUE(skin->find_tears(rest));
  const auto with_gap = [&](double gap) {
    std::vector<float> places = rest;
    for (std::size_t i = 0; i < places.size(); i += 3)
      if (rest[i] > kSpacing * kCut) places[i] += static_cast<float>(gap * kSpacing);
    return places;
  };
  EXPECT_TRUE(skin->find_tears(with_gap(0.4))) << "stretched";
  EXPECT_FALSE(skin->find_tears(with_gap(2)));
  for (std::size_t v = 0; v < skin->vertices(); ++v) {
    const double away = std::abs(surface.vertices[v].x() / kSpacing - kCut);
    if (away < 1.5) {
      EXPECT_TRUE(skin->torn(v)) << away;
    }
    if (away > 3.5) {
      EXPECT_FALSE(skin->torn(v)) << away;
    }
  }
  for (std::size_t i = 0; i < skin->particles(); ++i) {
    const double away = std::abs(rest[3 * i] / kSpacing - kCut);
    if (away < 2) {
      EXPECT_TRUE(skin->bare(i)) << away;
    }
    if (away > 6) {
      EXPECT_FALSE(skin->bare(i)) << away;
    }
  }
  EXPECT_TRUE(skin->find_tears(rest)) << "whole again";
  for (std::size_t i = 0; i < skin->particles(); ++i) EXPECT_FALSE(skin->bare(i));
  std::vector<float> lost = rest;
  lost[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(skin->find_tears(lost));
  EXPECT_TRUE(skin->bare(0));
}

}  // namespace
}  // namespace palp::test::skin_test
