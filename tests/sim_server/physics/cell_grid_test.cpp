// The cell grid's neighbour loop against every pair, on random clouds.
#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "sim_server/physics/list_team.h"
#include "tests/support/random_scene.h"
#include "tests/support/seed.h"

namespace palp::test::cell_grid_test {
namespace {

struct Cloud {
  CellGrid grid;
  Eigen::Vector3d length;
  std::vector<Packed> xV;            // sorted by cell
  std::vector<std::uint32_t> start;  // of the cells
};

Cloud make_cloud(std::vector<Eigen::Vector3d> points, const Eigen::Vector3d& origin, const Eigen::Vector3d& length,
                 const std::array<int, 3>& cells, const std::array<bool, 3>& periodic, bool tiled = false) {
  Cloud cloud;
  cloud.length = length;
  CellGrid& g = cloud.grid;
  g.tiled = tiled;
  for (int a = 0; a < 3; ++a) {
    g.origin[a] = real(origin[a]);
    g.cell[a] = real(length[a] / cells[a]);
    g.inv_cell[a] = real(cells[a] / length[a]);
    g.period[a] = periodic[a] ? real(length[a]) : real(0);
    g.n[a] = cells[a];
  }
  std::stable_sort(points.begin(), points.end(), [&](const auto& a, const auto& b) {
    return g.index_of(a.template cast<real>()) < g.index_of(b.template cast<real>());
  });
  cloud.start.assign(g.cells() + 1, 0);
  for (const Eigen::Vector3d& x : points) {
    cloud.xV.push_back(pack(x.cast<real>(), 1));
    ++cloud.start[g.index_of(x.cast<real>()) + 1];
  }
  for (std::uint32_t c = 0; c < g.cells(); ++c) cloud.start[c + 1] += cloud.start[c];
  g.start = cloud.start.data();
  return cloud;
}

using Found = std::map<std::uint32_t, Vec3>;  // separations by neighbour

void find(const Cloud& cloud, std::size_t i, double support, Found& found) {
  for_neighbors(cloud.grid, cloud.xV.data(), cloud.xV[i].xyz(), real(support), SerialTeam{},
                [&](std::uint32_t j, const Packed& x_j, const Vec3& d, real r2) {
                  EXPECT_EQ(x_j.x, cloud.xV[j].x);
                  EXPECT_TRUE(found.emplace(j, d).second) << "particle " << j << " came twice";
                  EXPECT_NEAR(r2, d.squaredNorm(), 1e-6);
                });
}

// The same from a list of what is within reach and more, as the CPU has them: one by one and by lanes, which take those
// at a time whose numbers are large.
void find_in_list(const Cloud& cloud, std::size_t i, double support, Found& found) {
  std::vector<std::uint32_t> list;
  const Vec3 x_i = cloud.xV[i].xyz();
  for (std::uint32_t j = 0; j < cloud.xV.size(); ++j)
    if (separation(cloud.grid, x_i, cloud.xV[j]).norm() < 1.3 * support) list.push_back(j);
  const ListTeam team(list.data(), list.data() + list.size());
  Found one_by_one;
  for_neighbors(cloud.grid, cloud.xV.data(), x_i, real(support), team,
                [&](std::uint32_t j, const Packed&, const Vec3& d, real) { one_by_one.emplace(j, d); });
  const auto alike = [&](std::uint32_t j) { return j > cloud.xV.size() / 3; };
  by_lanes(team, true, alike, [&](auto pairs) {
    using S = typename decltype(pairs)::Real;
    for_neighbors(cloud.grid, cloud.xV.data(), x_i, real(support), pairs,
                  [&](const auto& j, const PackedOf<S>& xV_j, const Vec3Of<S>& d, S r2) {
                    if constexpr (std::is_same_v<S, Lanes>) {
                      for (int k = 0; k < kLanes; ++k) {
                        if (!(xV_j.w.v[k] > 0)) continue;
                        EXPECT_EQ(real(xV_j.w.v[k]), cloud.xV[j.of[k]].w);
                        EXPECT_EQ(real(xV_j.y.v[k]), cloud.xV[j.of[k]].y);
                        EXPECT_EQ(alike(j.of[k]), alike(first_of(j)));
                        const Vec3 one(d[0].v[k], d[1].v[k], d[2].v[k]);
                        EXPECT_NEAR(r2.v[k], one.squaredNorm(), 1e-6);
                        EXPECT_TRUE(found.emplace(j.of[k], one).second) << "particle " << j.of[k] << " came twice";
                      }
                    }
                  });
    return true;
  });
  EXPECT_EQ(found.size(), one_by_one.size());
  for (const auto& [j, d] : one_by_one) EXPECT_EQ(found[j], d) << "particle " << j;
}

// The loop's neighbours of every particle are those that all pairs give, each once, with the right separation.
template <class Find>
void expect_same_neighbors(const Cloud& cloud, double support, const Find& find_them) {
  const CellGrid& g = cloud.grid;
  for (std::size_t i = 0; i < cloud.xV.size(); ++i) {
    Found found;
    find_them(cloud, i, support, found);
    EXPECT_TRUE(found.count(static_cast<std::uint32_t>(i))) << "a particle is its own neighbour";
    for (std::uint32_t j = 0; j < cloud.xV.size(); ++j) {
      Eigen::Vector3d d = (cloud.xV[i].xyz() - cloud.xV[j].xyz()).cast<double>();
      for (int a = 0; a < 3; ++a)
        if (g.periodic(a)) d[a] -= cloud.length[a] * std::round(d[a] / cloud.length[a]);
      const auto it = found.find(j);
      // round-off decides at the support radius itself
      if (std::abs(d.norm() - support) < 1e-5) continue;
      ASSERT_EQ(it != found.end(), d.norm() < support) << "pair " << i << ", " << j << " at distance " << d.norm();
      if (it != found.end()) {
        EXPECT_LT((it->second.cast<double>() - d).norm(), 1e-5);
      }
    }
  }
}

struct GridCase {
  const char* name;
  std::array<int, 3> cells;
  std::array<bool, 3> periodic;
  bool tiled = false;
};
void PrintTo(const GridCase& c, std::ostream* out) { *out << c.name; }

class Neighbors : public ::testing::TestWithParam<GridCase> {};

TEST_P(Neighbors, AreThoseOfAllPairs) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const GridCase& c = GetParam();
  constexpr double support = 0.25;
  const Eigen::Vector3d origin(-0.3, 0.2, -1);
  const Eigen::Vector3d length = support * Eigen::Vector3d(c.cells[0], c.cells[1], c.cells[2]) * 1.02;
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < 500; ++k) {
    Eigen::Vector3d x;
    for (int a = 0; a < 3; ++a) {
      // along walled axes some are outside the domain
      const double beyond = c.periodic[a] ? 0 : 0.4;
      x[a] = origin[a] + uniform(random, -beyond, length[a] + beyond * 0.999999);
    }
    points.push_back(x);
    if (k % 50 == 0) points.push_back(x);  // coincident
  }
  // on the domain's faces
  points.push_back(origin);
  points.push_back(origin + length * (1 - 1e-7));
  const Cloud cloud = make_cloud(points, origin, length, c.cells, c.periodic, c.tiled);
  expect_same_neighbors(cloud, support, find);
  expect_same_neighbors(cloud, support, find_in_list);
}

INSTANTIATE_TEST_SUITE_P(Grids, Neighbors,
                         ::testing::Values(GridCase{"walls", {4, 5, 3}, {false, false, false}},
                                           GridCase{"one_cell", {1, 1, 1}, {false, false, false}},
                                           GridCase{"periodic_x", {3, 4, 2}, {true, false, false}},
                                           GridCase{"periodic_yz", {2, 3, 3}, {false, true, true}},
                                           GridCase{"periodic_three_cells", {3, 3, 3}, {true, true, true}},
                                           GridCase{"periodic_long", {7, 3, 4}, {true, true, true}},
                                           GridCase{"tiles", {17, 9, 6}, {false, false, false}, true},
                                           GridCase{"one_tile", {8, 4, 4}, {false, false, false}, true},
                                           GridCase{"tiles_periodic", {11, 5, 3}, {true, true, true}, true}),
                         [](const auto& param) { return std::string(param.param.name); });

TEST(CellGrid, KnowsTheCellOfAnIndex) {
  for (const bool tiled : {false, true}) {
    const Cloud cloud =
        make_cloud({Eigen::Vector3d::Zero()}, {0, 0, 0}, {1, 1, 1}, {19, 6, 9}, {false, true, false}, tiled);
    std::set<std::uint32_t> seen;
    for (int z = 0; z < 9; ++z)
      for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 19; ++x) {
          const std::uint32_t index = cloud.grid.index(x, y, z);
          EXPECT_LT(index, cloud.grid.cells());
          EXPECT_TRUE(seen.insert(index).second) << index;
          int at[3];
          cloud.grid.cell_at(index, at);
          EXPECT_EQ((std::array{at[0], at[1], at[2]}), (std::array{x, y, z}));
        }
  }
}

TEST(CellGrid, WrapsIntoTheDomain) {
  const Cloud cloud = make_cloud({Eigen::Vector3d::Zero()}, {-1, 0, 0}, {2, 1, 1}, {4, 3, 3}, {true, false, true});
  const Vec3 x = cloud.grid.wrap(Vec3(real(-1.25), real(-0.5), real(1.125)));
  EXPECT_NEAR(x.x(), 0.75, 1e-6);
  EXPECT_NEAR(x.y(), -0.5, 1e-6) << "walled axes do not wrap";
  EXPECT_NEAR(x.z(), 0.125, 1e-6);
}

TEST(CellGrid, BinsNonFinitePositionsSomewhere) {
  const Cloud cloud = make_cloud({Eigen::Vector3d::Zero()}, {0, 0, 0}, {1, 1, 1}, {3, 3, 3}, {});
  const real nan = std::numeric_limits<real>::quiet_NaN(), inf = std::numeric_limits<real>::infinity();
  for (real bad : {nan, inf, -inf, real(1e30), real(-1e30)})
    EXPECT_LT(cloud.grid.index_of(Vec3(bad, bad, bad)), cloud.grid.cells());
}

}  // namespace
}  // namespace palp::test::cell_grid_test
