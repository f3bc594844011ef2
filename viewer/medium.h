// How the particles of a body are drawn.
#pragma once

#include <osg/Vec3f>
#include <osg/Vec4f>

#include "idl/messages.h"

namespace palp {

// beads: spheres. opaque, clear: one smooth surface, lit or looked through.
enum class Medium { beads, opaque, clear };

inline constexpr std::size_t kMediums = 3;

// The look that all of a medium has.
struct OneTint {
  osg::Vec3f color;    // of what is opaque (sRGB), or what a clear medium absorbs [1/m]
  osg::Vec4f surface;  // its surface_numbers(); of a clear medium haze [1/m] in place of softness
};

// Returns how the particles of a body are usually drawn: liquids and soft solids as their look says, what is neither as
// beads.
Medium usual_medium(const BodyDescription& body);

// Returns whether the body is a liquid that turns white where it flies apart.
bool foams(const BodyDescription& body);

// Returns whether the body's matter looks otherwise when it has changed state.
bool changes_look(const BodyDescription& body);

}  // namespace palp
