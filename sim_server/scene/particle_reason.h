// Why a body has particles. Rigid and fixed bodies act on each other, on elastic ones and on fluids by their geometry,
// so that most of them need none.
#pragma once

#include <cstdint>

#include "sim_server/scene/scene.h"

namespace palp {

enum class ParticleReason : std::uint8_t {
  none,         // it has no particles
  matter,       // it is a fluid or elastic
  paper,        // method "paper" computes every contact between particles
  asked,        // numerics.solid_particles is true
  adhesion,     // a fluid of the scene clings to particles
  shapeless,    // it consists of loose particles, to which there is no distance
  temperature,  // its temperature changes: it conducts heat, or heat zones warm it
  springs,      // it can meet a body that has no distance field
  bonded,       // an elastic body holds on to it: only the particles within its reach, but all if that changes state
};

// Returns the reason for the particles of a body of the scene; `none` for one that has none. Depends on what the scene
// consists of only, so it is the same before and after particles are left out.
ParticleReason particle_reason(const Scene& scene, std::size_t body);

// Returns a few words that complete "it has particles because": "a fluid of the scene clings to them".
const char* describe(ParticleReason reason);

// Returns the support radius H of elastic bodies with method "accurate" [m].
double elastic_support(const Scene& scene);

// Takes the particles out of the scene that nothing needs, with what the plan needs to know of them kept in
// Body::extent and Scene::left_out. Forces come out as with them.
void leave_out_particles(Scene& scene);

// Returns the height that moving matter can fall along an axis [m]: its extent, and the gap to the particles of fixed
// bodies below it. Zero where nothing moves. moves: by body. up: 1 where gravity points down the axis, else -1.
double fall_height(const Scene& scene, const std::vector<bool>& moves, int axis, double up);

}  // namespace palp
