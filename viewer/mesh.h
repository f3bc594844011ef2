// Surfaces of bodies as OSG geometry.
#pragma once

#include <atomic>
#include <cstddef>

#include <osg/Geometry>
#include <osg/ref_ptr>

#include "idl/messages.h"

namespace palp {

// The drawable parts of one body, in its body frame; null when there is nothing of that part. Normals are smooth but
// for creases. A fixed body that is hollow (a tray, a glass) is split: what faces its inside is solid, what faces away
// from it is glass, so that the contents show through the near wall and the far wall is still there.
struct BodyMesh {
  osg::ref_ptr<osg::Geometry> solid;
  osg::ref_ptr<osg::Geometry> glass;
  osg::ref_ptr<osg::Geometry> edges;  // creases as lines, of hollow bodies
};

// Tells other threads how far a build is, and lets them end it.
struct BuildProgress {
  std::atomic<std::size_t> done = 0;    // steps of build_work()
  std::atomic<bool> cancelled = false;  // ends the build within milliseconds
};

// Returns how many steps it takes to build the surface of the body: some 50 ns each.
std::size_t build_work(const BodyDescription& body);

// Triangles with an index out of range, a non-finite vertex or no area are left out. Any thread. Returns nothing when
// it is cancelled.
BodyMesh build_mesh(const BodyDescription& body, BuildProgress* progress = nullptr);

// Returns whether a body is described by a surface, which stands for its particles.
inline bool has_surface(const BodyDescription& body) { return !body.vertices.empty() && !body.triangles.empty(); }

}  // namespace palp
