// Fluid at rest sleeps: it is not computed, and stands still as a wall would, with the pressure that it fell asleep
// with, until something that moves comes near. Blocks of cells at least a neighbour list's reach wide decide.
//
// Every few milliseconds (kSleepInterval) all blocks are judged. One is stirred when a particle in it is faster than
// numerics.sleep_speed, or when a tool, or another rigid body that is faster, is within reach. Fluid sleeps where its
// own block and those next to it have been quiet for kSleepAfter, so between what moves and what sleeps lies fluid that
// is awake and slower than sleep_speed. That is the largest step of a velocity when a block falls asleep, and no
// pressure changes then. Particles of walls sleep one block further off, because fluid a block away asks for the
// pressure that they show. Particles of bodies that move, or whose wrench is asked for, do not sleep.
//
// With a region of interest all within it, around each tool, is stirred. Beyond it fluid sleeps as above, or, without a
// sleep_speed, whatever it does.
#pragma once

#include "sim_server/physics/elastic.h"

namespace palp {

// The time for which a block and those around it have been quiet before it sleeps [s]: half a period of the waves in a
// cup, which stand still twice a period.
inline constexpr double kSleepAfter = 0.25;
// The time between two looks at what may sleep or must wake: sound passes a block in about as long [s].
inline constexpr double kSleepInterval = 0.008;

// The box around a rigid body, relative to its centre of mass, body axes [m].
struct SleepBox {
  Vec3 center, half;
  bool tool;  // a proxy holds it
};

struct SleepViews {
  int n[3] = {0, 0, 0};                // blocks per axis
  int cells = 1;                       // cells per block and axis
  std::uint32_t* quiet = nullptr;      // by block: number of times that it was judged since it was stirred
  std::uint32_t patience = 0;          // that many of them make it sleep
  real interval = 0;                   // time between them [s]
  std::uint32_t* lists_due = nullptr;  // set when what wakes needs lists of neighbours
  const SleepBox* box = nullptr;       // in the order of BodyLists::rigid
  real speed = 0;                      // numerics.sleep_speed; 0: fluid beyond the region sleeps at any speed [m/s]
  real region = 0;                     // distance from tools within which nothing sleeps [m]

  PALP_HD std::uint32_t blocks() const { return static_cast<std::uint32_t>(n[0]) * n[1] * n[2]; }
  PALP_HD std::uint32_t index(int bx, int by, int bz) const {
    return (static_cast<std::uint32_t>(bz) * n[1] + by) * n[0] + bx;
  }
};

// The place of a block in the grid.
struct SleepBlock {
  int at[3];
  Vec3 center;
  real radius;  // half of its diagonal [m]
};

PALP_HD inline SleepBlock sleep_block(const SleepViews& sleep, const CellGrid& grid, std::uint32_t index) {
  SleepBlock b{};
  const auto nx = static_cast<std::uint32_t>(sleep.n[0]), ny = static_cast<std::uint32_t>(sleep.n[1]);
  b.at[0] = static_cast<int>(index % nx);
  b.at[1] = static_cast<int>(index / nx % ny);
  b.at[2] = static_cast<int>(index / nx / ny);
  for (int a = 0; a < 3; ++a)
    b.center[a] =
        grid.origin[a] + (static_cast<real>(b.at[a]) + real(0.5)) * static_cast<real>(sleep.cells) * grid.cell[a];
  b.radius = real(0.5) * static_cast<real>(sleep.cells) * grid.cell.norm();
  return b;
}

// Calls f(i) for the particles of a block, shared among the lanes of a team.
template <class Team, class F>
PALP_HD inline void for_each_in_block(const SleepViews& sleep, const CellGrid& grid, const SleepBlock& b, Team team,
                                      F&& f) {
  int first[3], end[3];
  for (int a = 0; a < 3; ++a) {
    first[a] = b.at[a] * sleep.cells;
    end[a] = first[a] + sleep.cells < grid.n[a] ? first[a] + sleep.cells : grid.n[a];
  }
  for (int z = first[2]; z < end[2]; ++z)
    for (int y = first[1]; y < end[1]; ++y)
      grid.for_row(first[0], end[0] - 1, y, z, [&](std::uint32_t from, std::uint32_t last) {
        for (std::uint32_t i = from + team.lane(); i < last; i += team.size()) f(i);
      });
}

// Returns the distance of x from a body's box; less than zero nowhere [m].
PALP_HD inline real distance_from(const CellGrid& grid, const BodyState& body, const SleepBox& box, const Vec3& x) {
  const Vec3 local = body.q.conjugate() * separation(grid, x, pack(body.x, 0)) - box.center;
  Vec3 out;
  for (int a = 0; a < 3; ++a) {
    const real past = Eigen::numext::abs(local[a]) - box.half[a];
    out[a] = past > real(0) ? past : real(0);
  }
  return out.norm();
}

// Marks the blocks within reach of a tool or of a rigid body that moves; one team a body.
struct MarkBodies {
  CellGrid grid;
  SleepViews sleep;
  const BodyState* body;
  const std::uint32_t* rigid;
  real support;  // with the margin of the neighbour lists [m]

  template <class Team>
  PALP_HD void operator()(std::uint32_t k, Team team) const {
    const BodyState& b = body[rigid[k]];
    const SleepBox box = sleep.box[k];
    const real size = box.center.norm() + box.half.norm(), speed = b.v.norm() + size * b.w.norm();
    if (!box.tool && speed <= sleep.speed) return;
    real reach = support + sleep.interval * speed;  // as far as it comes until it is looked at again
    if (box.tool && reach < sleep.region) reach = sleep.region;
    int first[3], count[3];
    for (int a = 0; a < 3; ++a) {
      const real far = size + reach;
      first[a] = grid.periodic(a) ? 0 : grid.cell_of(b.x[a] - far, a) / sleep.cells;
      count[a] = (grid.periodic(a) ? sleep.n[a] : grid.cell_of(b.x[a] + far, a) / sleep.cells + 1) - first[a];
    }
    const std::uint32_t all = static_cast<std::uint32_t>(count[0]) * count[1] * count[2];
    for (std::uint32_t c = team.lane(); c < all; c += team.size()) {
      const int x = static_cast<int>(c) % count[0], y = static_cast<int>(c) / count[0] % count[1],
                z = static_cast<int>(c) / count[0] / count[1];
      const std::uint32_t index = sleep.index(first[0] + x, first[1] + y, first[2] + z);
      const SleepBlock block = sleep_block(sleep, grid, index);
      if (distance_from(grid, b, box, block.center) < reach + block.radius) sleep.quiet[index] = 0;
    }
  }
};

// Counts for each block how often it has been judged since a particle there was fast, or a body marked it.
struct JudgeMotion {
  ParticleView state;
  CellGrid grid;
  SleepViews sleep;
  const Forcing* forcing;

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const SleepBlock b = sleep_block(sleep, grid, index);
    const real fast2 = sleep.speed * sleep.speed;
    std::uint32_t fast = 0;
    if (sleep.speed > real(0))
      for_each_in_block(sleep, grid, b, team, [&](std::uint32_t i) {
        // not a number counts as fast, so that health sees it
        if (!(state.vp[i].xyz().squaredNorm() <= fast2)) ++fast;
      });
    const bool moved = team.sum(static_cast<real>(fast)) > real(0);
    if (!team.leader()) return;
    std::uint32_t& quiet = sleep.quiet[index];
    if (forcing->changed || moved)
      quiet = 0;
    else if (quiet < sleep.patience)
      ++quiet;
  }
};

// Stills the particles of blocks that are quiet and wakes those of blocks that are not.
struct Settle {
  ParticleView state, sorted;
  CellGrid grid;
  SleepViews sleep;
  const BodyState* body;  // null without solids
  ElasticViews elastic;   // count 0 where no elastic body may sleep

  // Says whether a particle sleeps. Those that have a force of their own, added up anew from all stages, sleep with the
  // unit that they are of (elastic_sleep.h), or not at all; those that no bond pulls at, whose force is that of what is
  // around them, as walls do.
  PALP_HD bool sleeps(Tag tag, std::uint32_t id, bool fluid_sleeps, bool walls_sleep) const {
    if (tag.is_fluid()) return fluid_sleeps;
    const BodyState& b = body[tag.body()];
    if (b.force_first == kNone) return tag.kind() == BodyKind::fixed && walls_sleep;
    const std::uint32_t k = b.force_first + id - b.first;
    if (k >= elastic.count) return false;
    return elastic.inert(k) ? walls_sleep : elastic.tag[k].asleep();
  }

  // Returns true when a block at most `ring` blocks away has been stirred of late. The lanes share its rows.
  template <class Team>
  PALP_HD bool stirred(const SleepBlock& b, int ring, Team team) const {
    const std::uint32_t edge = 2 * static_cast<std::uint32_t>(ring) + 1;
    std::uint32_t found = 0;
    for (std::uint32_t c = team.lane(); c < edge * edge; c += team.size()) {
      int y = b.at[1] + static_cast<int>(c % edge) - ring, z = b.at[2] + static_cast<int>(c / edge) - ring;
      if (!within(y, 1) || !within(z, 2)) continue;
      for (int x = b.at[0] - ring; x <= b.at[0] + ring; ++x) {
        int at = x;
        if (within(at, 0) && sleep.quiet[sleep.index(at, y, z)] < sleep.patience) ++found;
      }
    }
    return team.sum(static_cast<real>(found)) > real(0);
  }

  // Returns false for a block that does not exist; goes on at the other end of a periodic axis.
  PALP_HD bool within(int& at, int axis) const {
    if (grid.periodic(axis)) at = (at + 2 * sleep.n[axis]) % sleep.n[axis];
    return at >= 0 && at < sleep.n[axis];
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    const SleepBlock b = sleep_block(sleep, grid, index);
    std::uint32_t count = 0;
    for_each_in_block(sleep, grid, b, team, [&](std::uint32_t) { ++count; });
    if (!(team.sum(static_cast<real>(count)) > real(0))) return;
    const bool walls_sleep = !stirred(b, 2, team), fluid_sleeps = walls_sleep || !stirred(b, 1, team);
    for_each_in_block(sleep, grid, b, team, [&](std::uint32_t i) {
      const Tag tag = state.tag[i];
      const bool rests = sleeps(tag, state.id[i], fluid_sleeps, walls_sleep);
      if (rests == tag.asleep()) return;
      state.tag[i] = sorted.tag[i] = tag.as_asleep(rests);
      if (tag.kind() != BodyKind::fixed) state.vp[i] = sorted.vp[i] = pack(Vec3(0, 0, 0), state.vp[i].w);
      if (!rests) raise_flag(sleep.lists_due);
    });
  }
};

}  // namespace palp
