// Which particles of a liquid fly apart from the others, and how white they get. Pure.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <osg/Vec3f>
#include <osg/Vec4f>

#include "idl/particle_frame.h"
#include "viewer/interior.h"

namespace palp {

// How much company a particle has is a sum over the others: each counts 1 up to kNearSpacings and ever less out to
// kReachSpacings, where the spheres that the surface is made of (medium_surface.cpp) no longer meet.
inline constexpr double kNearSpacings = 1.0, kReachSpacings = 1.5;

// Returns how much a particle is on its own, from 1 without company to 0 where it is part of a sheet: it falls smoothly
// with the company and never rises.
float aloneness(float company);

// Returns likewise how much air there is about a particle: nearer to the liquid, too, thin sheets have some.
float airiness(float company);

// Returns how white a particle is with so much air about it and so fast [m/s]: 0 of what is slow or no speed, 1 of what
// is fast and alone.
float whiteness(float airy, float speed);

// Returns how fast that particle is [m/s], by two frames of the same particles; 0 where they do not say: earlier is
// null or not a little earlier, the particle is in one of them only, or it was put elsewhere in between.
osg::Vec3f velocity_of(std::size_t particle, const ParticleFrame& frame, const ParticleFrame* earlier);

struct Flying {
  std::uint32_t place;
  float alone;  // how much it is a drop
  float airy;   // how much its liquid is torn apart there; not less, and above 0
};

// Returns those of the places, by their order, that are more or less on their own. interior: has found these places,
// with what is loose, at this spacing [m]; what is not loose there is taken for part of the liquid. others: places of
// other liquids, x y z each, which are company, too; they need not be finite.
std::vector<Flying> find_flying(std::span<const osg::Vec4f> places, const Interior& interior, double spacing,
                                std::span<const std::span<const float>> others = {});

}  // namespace palp
