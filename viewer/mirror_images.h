// Mirror images of the particles that touch a solid: with them a medium's surface goes on into the solid, where the
// picture ends it at the wall, in place of turning round half a spacing before it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <osg/BoundingBox>
#include <osg/Geometry>
#include <osg/Vec3f>

#include "viewer/welded_surface.h"

namespace palp {

// The faces of one solid, found by place. Any thread may ask.
class MirrorImages {
 public:
  // solid: the solid's surface, in its body frame, or of one that is hollow what looks into its hollow; shell: what
  // else that one has, or null. spacing: of the particles, above 0 [m]. Surfaces of very many triangles, or of very
  // many that are large and slanted, have no images.
  MirrorImages(const osg::Geometry* solid, const osg::Geometry* shell, double spacing);
  // Adds the images of a particle at x in the faces that it touches, in their edges and corners, all in the body frame.
  // Never more than kMost. Returns whether the particle stands in a hollow, whose walls have images however thin they
  // are: the picture ends them at the hollow's faces. Elsewhere a wall too thin to hold an image has none.
  bool add_of(const osg::Vec3f& x, std::vector<osg::Vec3f>& images) const;
  // The box that particles are in which may have images; invalid where none has.
  const osg::BoundingBox& box() const { return box_; }

  static constexpr std::size_t kMost = 7;

 private:
  struct Face {
    osg::Vec3f corner, edge[2];  // from that corner to the others
    osg::Vec3f normal;
    osg::Vec3f shares[2];  // a place's share of each edge is its way from the corner times these
    float slack[3];        // in those shares and in their sum, for places just beside the face
    bool in_hollow;
  };
  struct Lattice;
  struct Touched {
    osg::Vec3f normal;
    float height;  // of the particle above it [m]
    bool in_hollow;
  };

  bool add_faces(const osg::Geometry* part, bool in_hollow);
  static bool holds(const Face& face, const osg::Vec3f& way);
  void sort_into_cells();
  std::span<const std::uint32_t> near(const osg::Vec3f& x) const;
  std::size_t touched_by(const osg::Vec3f& x, std::array<Touched, 3>& out) const;
  bool is_thick(const Face& face, const osg::Vec3f& foot, std::span<const std::uint32_t> near) const;

  float spacing_;
  std::vector<Face> faces_;
  osg::BoundingBox box_;
  float per_metre_ = 0;                      // cells
  std::array<std::uint32_t, 3> cells_{};     // along each axis
  std::vector<std::uint32_t> first_, list_;  // of each cell the first of its faces in the list
};

}  // namespace palp
