// Which pairs of particles neighbour lists hold.
#pragma once

#include "sim_server/physics/wall_sight.h"

namespace palp {

// Says whether two particles ever act on each other: stored neighbour lists leave out the pairs that do not.
struct EveryPair {
  PALP_HD bool operator()(Tag, Tag) const { return true; }
  PALP_HD static ClearSpace clear_around(Tag, const Vec3&) { return all_clear(); }
  PALP_HD static bool in_sight(Tag, const Vec3&, const Vec3&, const ClearSpace&) { return true; }
};

// The same with solids.
struct Interacts : EveryPair {
  bool all;  // method "paper": a solid's own particles count in its density; heat: they conduct
  bool contact;
  bool cohesion;  // fluids cling to solids that else act by their geometry
  PALP_HD bool operator()(Tag a, Tag b) const {
    if (all) return true;
    if (a.is_fluid() || b.is_fluid()) return cohesion || !(a.by_geometry() || b.by_geometry());
    return contact && a.body() != b.body() && (a.kind() != BodyKind::fixed || b.kind() != BodyKind::fixed);
  }
};

// The same with thin walls, across which fluids do not interact.
struct InteractsInSight : Interacts {
  WallSight sight;
  // Returns where around a particle at x all are in its sight.
  PALP_HD ClearSpace clear_around(Tag a, const Vec3& x) const {
    return a.is_fluid() ? sight.clear_around(x) : all_clear();
  }
  // Returns whether particle i, with such a space around it, sees one with tag b at x_i - x_ij.
  PALP_HD bool in_sight(Tag b, const Vec3& x_i, const Vec3& x_ij, const ClearSpace& clear) const {
    return !b.is_fluid() || clear.holds(x_ij) || sight.open(x_i, x_ij);
  }
};

}  // namespace palp
