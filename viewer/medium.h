// How the particles of a body are drawn.
#pragma once

#include <osg/Vec3f>
#include <osg/Vec4f>

#include "idl/messages.h"

namespace palp {

// beads: spheres. opaque, clear: one smooth surface, lit or looked through.
enum class Medium { beads, opaque, clear };

inline constexpr std::size_t kMediums = 3;

// The colour (sRGB) and the surface_numbers() of a look that all of an opaque medium has.
struct OneTint {
  osg::Vec3f color;
  osg::Vec4f surface;
};

// Returns how the particles of a body are usually drawn: liquids and soft solids as their look says, what is neither as
// beads.
Medium usual_medium(const BodyDescription& body);

// Returns whether the body's matter looks otherwise when it has changed state.
bool changes_look(const BodyDescription& body);

}  // namespace palp
