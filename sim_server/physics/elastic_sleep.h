// Elastic bodies at rest sleep as fluid does (sleep.h), each as a whole: a part of one that stood still would make the
// rest stiffer. A unit is a body with the particles that it is bonded to, or several that share such particles. Where
// neighbours are listed it is stirred with a block that it lies in or near, else by its own motion and by tools and
// rigid bodies within reach. Back ends pass over the particles of units that sleep; what stages keep by particle stays
// as it was, the forces that hold the unit among it, so that what it rests on and what it is bonded to go on feeling
// its weight. Particles of fixed bodies that are too deep for bonds (ElasticViews::inert) sleep for good in the order
// of forces; in that of cells they sleep as walls do.
#pragma once

#include "sim_server/physics/implicit_elastic.h"
#include "sim_server/physics/sleep.h"

namespace palp {

struct SleepUnit {
  std::uint32_t first, count;  // in ElasticSleepViews::member
  std::uint32_t quiet;         // number of times that it was judged since it was stirred
  Vec3 low, high;              // box around its particles [m]
};

struct ElasticSleepViews {
  std::uint32_t units = 0;
  SleepUnit* unit = nullptr;
  const std::uint32_t* member = nullptr;  // indices of particles in the order of forces
};

// Judges whether a unit is stirred, and stills or wakes its particles; one team a unit.
struct JudgeElastic {
  ParticleView state;  // where no neighbours are listed nothing sorts it: it is in the scene's order
  ElasticViews elastic;
  ImplicitViews solve;  // null pointers where elasticity is explicit
  ElasticSleepViews units;
  SleepViews sleep;
  CellGrid grid;
  Medium medium;
  const BodyState* body;
  const std::uint32_t* rigid;
  std::uint32_t rigid_count;
  const Forcing* forcing;
  int ring;  // blocks from the unit within which nothing may be stirred

  // Returns true when a tool is within reach of the box, or a rigid body that moves.
  PALP_HD bool met(const SleepUnit& unit) const {
    for (std::uint32_t k = 0; k < rigid_count; ++k) {
      const BodyState& b = body[rigid[k]];
      const real size = sleep.box[k].center.norm() + sleep.box[k].half.norm(), speed = b.v.norm() + size * b.w.norm();
      if (!sleep.box[k].tool && speed <= sleep.speed) continue;
      const Vec3 middle = real(0.5) * (unit.low + unit.high), half = real(0.5) * (unit.high - unit.low);
      const Vec3 apart = separation(grid, b.x, pack(middle, 0));
      Vec3 out;
      for (int a = 0; a < 3; ++a) {
        const real past = Eigen::numext::abs(apart[a]) - half[a];
        out[a] = past > real(0) ? past : real(0);
      }
      real reach = real(2) * medium.spacing + sleep.interval * speed;
      if (sleep.box[k].tool && reach < sleep.region) reach = sleep.region;
      if (out.norm() < size + reach) return true;
    }
    return false;
  }

  // Returns true when a block has been stirred that is in reach of what the box may touch.
  template <class Team>
  PALP_HD bool near_stirred(const SleepUnit& unit, Team team) const {
    int first[3], count[3];
    for (int a = 0; a < 3; ++a) {
      const int low = grid.cell_of(unit.low[a], a) / sleep.cells - ring,
                high = grid.cell_of(unit.high[a], a) / sleep.cells + ring;
      first[a] = low > 0 ? low : 0;
      count[a] = (high < sleep.n[a] ? high + 1 : sleep.n[a]) - first[a];
      if (grid.periodic(a)) first[a] = 0, count[a] = sleep.n[a];
    }
    const std::uint32_t all = static_cast<std::uint32_t>(count[0]) * count[1] * count[2];
    real found = 0;
    for (std::uint32_t c = team.lane(); c < all; c += team.size()) {
      const int x = static_cast<int>(c) % count[0], y = static_cast<int>(c) / count[0] % count[1],
                z = static_cast<int>(c) / count[0] / count[1];
      if (sleep.quiet[sleep.index(first[0] + x, first[1] + y, first[2] + z)] < sleep.patience) found = real(1);
    }
    return team.max(found) > real(0);
  }

  // Measures the unit's box, and returns true when one of its particles is fast.
  template <class Team>
  PALP_HD bool measure(SleepUnit& unit, Team team) const {
    const real fast2 = sleep.speed * sleep.speed, none = real(-1e30);
    real fast = 0;
    Vec3 most(none, none, none), least(none, none, none);
    for (std::uint32_t p = team.lane(); p < unit.count; p += team.size()) {
      const std::uint32_t i = units.member[unit.first + p];
      const Vec3 x = elastic.rest[i].xyz() + elastic.u[i].xyz();
      most = most.cwiseMax(x);
      least = least.cwiseMax(-x);
      if (sleep.speed > real(0) && !(elastic.v[i].xyz().squaredNorm() <= fast2)) fast = real(1);
    }
    for (int a = 0; a < 3; ++a) {
      unit.high[a] = team.max(most[a]);
      unit.low[a] = -team.max(least[a]);
    }
    return team.max(fast) > real(0);
  }

  PALP_HD void change(std::uint32_t i, bool sleeps) const {
    const Tag tag = elastic.tag[i] = elastic.tag[i].as_asleep(sleeps);
    if (sleep.blocks() == 0) {
      const BodyState& b = body[tag.body()];
      Tag& shown = state.tag[b.first + i - b.force_first];
      shown = shown.as_asleep(sleeps);
    }
    if (!sleeps) return;
    const Packed zero{0, 0, 0, 0};
    elastic.v[i] = zero;
    if (solve.predicted == nullptr) return;
    solve.predicted[i] = elastic.u[i];
    solve.residual[i] = pack(Vec3(0, 0, 0), solve.residual[i].w);
    solve.scaled[i] = solve.image[i] = solve.direction[i] = solve.advance[i] = solve.change[i] = zero;
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t index, Team team) const {
    SleepUnit unit = units.unit[index];
    const bool slept = unit.quiet >= sleep.patience, moved = measure(unit, team);  // which waits for all to have read
    if (sleep.blocks() > 0)
      unit.quiet = near_stirred(unit, team) ? 0 : sleep.patience;  // the blocks have been patient
    else if (forcing->changed || moved || met(unit))
      unit.quiet = 0;
    else if (unit.quiet < sleep.patience)
      ++unit.quiet;
    const bool sleeps = unit.quiet >= sleep.patience;
    if (sleeps != slept)
      for (std::uint32_t p = team.lane(); p < unit.count; p += team.size())
        change(units.member[unit.first + p], sleeps);
    if (team.leader()) units.unit[index] = unit;
  }
};

}  // namespace palp
