#include "viewer/force_arrow.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "viewer/arrow_parts.h"
#include "viewer/color_map.h"

namespace palp {
namespace {

constexpr double kHeadRadiusOverShaft = 2.6;
constexpr double kHeadLengthOverShaft = 6.5;
constexpr double kMemory = 6;  // [s] in which the remembered peak falls by a factor of e

}  // namespace

ForceArrow::ForceArrow(const osg::Vec4f& color)
    : pose_(new osg::MatrixTransform), shaft_(new osg::MatrixTransform), head_(new osg::MatrixTransform) {
  const std::array<osg::Vec2f, 4> rod{osg::Vec2f(0, 0), osg::Vec2f(1, 0), osg::Vec2f(1, 1), osg::Vec2f(0, 1)};
  const std::array<osg::Vec2f, 3> cone{osg::Vec2f(0, 0), osg::Vec2f(1, 0), osg::Vec2f(0, 1)};
  shaft_->addChild(revolve(rod, color));
  head_->addChild(revolve(cone, color));
  pose_->addChild(shaft_);
  pose_->addChild(head_);
  root_ = seen_and_hidden(pose_);
  hide();
}

void ForceArrow::hide() { root_->setNodeMask(0); }

void ForceArrow::set(const osg::Vec3d& origin, const osg::Vec3d& force, double length, double thickness) {
  const bool drawable = origin.valid() && force.valid() && std::isfinite(length) && length > thickness &&
                        thickness > 0 && force.length2() > 0;
  if (!drawable) {
    hide();
    return;
  }
  root_->setNodeMask(~0u);
  // a short arrow keeps its shape: the head never takes more than half of it
  const double shape = std::min(1.0, 0.5 * length / (kHeadLengthOverShaft * thickness));
  const double head = kHeadLengthOverShaft * thickness * shape;
  const double shaft_radius = thickness * std::max(shape, 0.5);
  pose_->setMatrix(osg::Matrixd::rotate(osg::Vec3d(0, 0, 1), force) * osg::Matrixd::translate(origin));
  shaft_->setMatrix(osg::Matrixd::scale(shaft_radius, shaft_radius, length - head));
  head_->setMatrix(osg::Matrixd::scale(kHeadRadiusOverShaft * shaft_radius, kHeadRadiusOverShaft * shaft_radius, head) *
                   osg::Matrixd::translate(0, 0, length - head));
}

double ForceScale::update(double force, double sim_time) {
  const double passed = sim_time >= time_ ? sim_time - time_ : 0;  // time runs backwards at a reset
  time_ = sim_time;
  peak_ *= std::exp(-passed / kMemory);
  if (std::isfinite(force)) peak_ = std::max(peak_, force);
  const double wanted = nice_ceiling(std::max(peak_, smallest_));
  if (wanted > full_scale_ || peak_ < 0.3 * full_scale_) full_scale_ = wanted;
  return full_scale_;
}

}  // namespace palp
