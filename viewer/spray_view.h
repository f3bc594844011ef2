// The drops that a liquid's particles are where they fly alone, and the white around fast ones.
#pragma once

#include <array>
#include <cstddef>

#include <osg/Group>
#include <osg/Switch>
#include <osg/Vec3f>
#include <osg/Vec4f>
#include <osg/Vec4ub>
#include <osg/ref_ptr>

#include "viewer/front_to_back.h"
#include "viewer/points.h"
#include "viewer/streamed_array.h"

namespace palp {

// All calls from the thread that renders, between frames. Sets of arrays take turns as those of ParticleCloud do.
class SprayView {
 public:
  SprayView();
  osg::Node* node() { return root_; }

  void set_spacing(double spacing);  // of the particles [m]
  void set_picture_height(int height);
  void clear();
  // Takes what flies in a frame, drop by drop, between begin() and end().
  void begin();
  // place: its middle [m], and in w how much of the particle is a drop, 0 .. 1. motion: its velocity [m/s], and in w
  // how white it gets, of what its look allows, 0 .. 1. tint: as medium.vert takes it. particle: its number, which says
  // how it falls apart.
  void add(const osg::Vec4f& place, const osg::Vec4f& motion, const osg::Vec4ub& tint, std::size_t particle);
  void end();
  std::size_t drops() const { return drops_; }

 private:
  static constexpr std::size_t kSets = 3;
  struct Set {
    osg::ref_ptr<StreamedArray<osg::Vec4Array>> places, motions;
    osg::ref_ptr<StreamedArray<osg::Vec4ubArray>> tints;
    std::array<osg::ref_ptr<osg::Geometry>, 2> points;  // of drops and of the white
  };

  void order(Set& set);

  osg::ref_ptr<osg::Group> root_;
  std::array<osg::ref_ptr<osg::Switch>, 2> switches_;
  std::array<Set, kSets> sets_;
  FrontToBack far_to_near_;
  std::size_t next_ = 0;
  std::size_t drops_ = 0;
};

}  // namespace palp
