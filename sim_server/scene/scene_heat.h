// Facts of a scene that the plan of heat rests on: whether it flows, what changes state, and which solids bound it.
#pragma once

#include "sim_server/scene/scene.h"

namespace palp {

// Returns whether the bodies of the scene have temperatures: all of them, or none.
bool has_temperatures(const Scene& scene);

// Returns whether temperatures exist and something conducts, heats or cools.
bool has_heat(const Scene& scene);

// Returns true for a body that changes state: fluid or elastic, of a material with a stiffness that melts or sets, in a
// scene with heat.
bool changes_state(const Scene& scene, const Body& body);

// Returns true for a rigid or fixed body with a distance field whose temperature stays as it is: it is held, or the
// body does not conduct and no zone heats it. Then heat flows to its surface, or none does (heat_walls.h), and no
// particles need to carry it. What a body that does not conduct would lose to air comes from an infinitely thin layer.
bool bounds_heat(const Scene& scene, const Body& body);

}  // namespace palp
