// The bonds that the gradient of an elastic particle is taken from. Host only.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "config/scene_config.h"
#include "sim_server/physics/gradient_correction.h"

namespace palp {

// Returns true for a material whose gradients are taken from balanced bonds. One that tears keeps all of them: its
// tears were found with those.
bool takes_balanced_bonds(const MaterialConfig& material);

// A bond of a particle.
struct RestBond {
  Eigen::Vector3d X;  // to the neighbour at rest
  double weight;      // volume times F
  bool elastic;       // to an elastic particle
};

// Returns, for each bond of an elastic particle, whether its gradient is taken from it.
//
// With all neighbours on one side a gradient is that of a place further in, by 0.15 spacings at a face, and sections of
// few spacings bend and twist too easily: five across had 15 and 22 % too little stiffness without the force against
// hourglass modes. So a bond counts if there is a neighbour near its mirror image, or if it is short: along a face the
// gradient is that of the face, and into it that of the way to the next layer. On a lattice those are exact for fields
// of the second degree but for what bends along the face's normal. Bonds past the 26 nearest of a lattice add to the
// error alone. Where such bonds would make a gradient stiffer than at the edge of a block, all count, as at corners.
std::vector<bool> balanced_bonds(const std::vector<RestBond>& bonds, double spacing);

// Returns the same for a particle of a rigid or fixed body: the bond that leads straight to an elastic particle, and
// those along its own body's face, which cannot stretch; where lattices do not match, all bonds to elastic particles.
// Bonds to what lies behind it would halve its strain, and the clamp would let go of half a spacing beyond its face; as
// it is, of none (0.1 spacings are held in front of it).
std::vector<bool> bonds_of_clamp(const std::vector<RestBond>& bonds, double spacing);

// Returns the correction of a gradient that is taken from the bonds that count.
GradientCorrection<double> gradient_correction_of(const std::vector<RestBond>& bonds, const std::vector<bool>& counts,
                                                  double flat);

}  // namespace palp
