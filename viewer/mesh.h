// Surfaces of bodies as OSG geometry.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>

#include <osg/Geometry>
#include <osg/ref_ptr>

#include "idl/messages.h"

namespace palp {

class MirrorImages;

// The drawable parts of one body, in its body frame; null when there is nothing of that part. Normals are smooth but
// for creases. A fixed body that is hollow (a tray, a glass) is split: what faces its inside is solid, what faces away
// from it is glass, so that the contents show through the near wall and the far wall is still there.
struct BodyMesh {
  osg::ref_ptr<osg::Geometry> solid;
  osg::ref_ptr<osg::Geometry> glass;
  osg::ref_ptr<osg::Geometry> edges;           // creases as lines, of hollow bodies
  std::shared_ptr<const MirrorImages> images;  // of what touches the body; none in a soft one
};

// Tells other threads how far a build is, and lets them end it.
struct BuildProgress {
  std::atomic<std::size_t> done = 0;    // steps of build_work()
  std::atomic<bool> cancelled = false;  // ends the build within milliseconds
};

// Returns how many steps it takes to build the surface of the body: some 50 ns each.
std::size_t build_work(const BodyDescription& body);

// Triangles with an index out of range, a non-finite vertex or no area are left out. Any thread. Returns nothing when
// it is cancelled. longest_edge: above 0, edges are that long at most [m], for a surface that bends.
BodyMesh build_mesh(const BodyDescription& body, BuildProgress* progress = nullptr, double longest_edge = 0);

// Returns whether a body is described by a rigid surface, which stands for its particles.
inline bool has_surface(const BodyDescription& body) {
  return body.kind != BodyKind::elastic && !body.vertices.empty() && !body.triangles.empty();
}

// Returns whether a soft body has a surface that its particles can carry along (skin.h), and that looks like it: what
// is clear has a thickness.
bool has_skin(const BodyDescription& body);

}  // namespace palp
