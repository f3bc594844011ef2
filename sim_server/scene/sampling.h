// Filling solids with particles: regular lattices of cell centres.
#pragma once

#include <vector>

#include "sim_server/geometry/solid.h"

namespace palp {

struct Particles {
  std::vector<Eigen::Vector3d> position;
  std::vector<Eigen::Vector3d> velocity;  // one per particle, or empty
  std::vector<double> volume;             // [m^3]
  std::vector<double> temperature;        // [K], one per particle, or empty
  bool exact = false;                     // the volumes add up to that of the solid
};

// Cell centres inside the solid, in the solid's frame. Boxes along its axes are filled exactly: each stretch between
// two neighbouring faces is divided into round(length / spacing) equal cells. Anything else gets a lattice that fills
// the first part's bounding box in that way and goes on beyond it, or, around a sphere, cylinder or mesh whose volume
// the cells would miss by more than 0.5 %, one up to 4 % finer or coarser whose cells have it. A particle's volume is
// that of its cell; the cells of boxes add up to the solid's `volume` [m^3]. Stops at max_particles + 1.
Particles fill_solid(const Solid& solid, double volume, double spacing, std::size_t max_particles);

// Parts that are added, but in which no particle of `filled` lies (index into solid.parts).
std::vector<std::size_t> empty_parts(const Solid& solid, const Particles& filled);

}  // namespace palp
