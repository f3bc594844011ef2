// The marks on a tool's surface where media touch it: a tint by their pressure where that is sent, else by nearness.
#pragma once

#include <span>
#include <vector>

#include <osg/BoundingBox>
#include <osg/Geometry>
#include <osg/Group>
#include <osg/Matrixd>
#include <osg/Vec3f>
#include <osg/ref_ptr>

#include "idl/particle_frame.h"
#include "viewer/cells.h"
#include "viewer/color_map.h"
#include "viewer/touch.h"
#include "viewer/welded_surface.h"

namespace palp {

// How pressures are read; without them all that is touched has one colour.
struct PressureColors {
  ValueRange range;  // [Pa]
  ColorMapKind map = ColorMapKind::sequential;
};

// All calls from the thread that renders, between frames.
class TouchMarks {
 public:
  // spacing: of the particles [m].
  explicit TouchMarks(double spacing);
  // To be put into the body's frame.
  osg::Node* node() { return root_; }
  // Adds a part of the tool's surface, in its body frame. It is cut finely when marks are first set.
  void add_part(const osg::Geometry& part);
  // Marks what particles of these ranges touch: those on the outer side and within a spacing of the surface, which
  // fades until 1.2 spacings. pose: of the body. pressures: null while the frame's scalars are no pressures. Returns
  // how much is touched.
  Touch set(const ParticleFrame& frame, std::span<const ParticleRange> media, const osg::Matrixd& pose,
            const PressureColors* pressures);
  void hide() { root_->setNodeMask(0); }
  // Returns how far each vertex is touched: 0 .. 1.
  std::span<const float> touched() const { return touched_; }
  // The surface as it was cut, and its vertices' normals.
  const Surface& surface() const { return surface_; }
  std::span<const osg::Vec3f> normals() const { return normals_; }

 private:
  void cut_parts();
  void add(const osg::Vec3f& particle, float pressure);
  void draw(const PressureColors* pressures);

  float spacing_;
  osg::ref_ptr<osg::Group> root_;
  // The same triangles thrice: where no solid hides them, whole where nothing does, faint where a medium does.
  osg::ref_ptr<osg::Geometry> reached_, seen_, hidden_;
  std::vector<osg::ref_ptr<const osg::Geometry>> uncut_;
  Surface surface_;
  std::vector<osg::Vec3f> normals_;  // by vertex
  std::vector<float> areas_;         // by vertex: a third of its triangles' [m^2]
  std::vector<float> touched_;       // by vertex: 0 .. 1
  std::vector<float> weights_;       // by vertex: of what adds to its pressure
  std::vector<float> pressure_;      // by vertex [Pa], times the weight while they are added up
  Cells cells_;                      // of the vertices, as wide as marks reach
  osg::BoundingBox box_;             // the vertices and what marks reach; particles beyond it touch none
};

}  // namespace palp
