#include "viewer/torque_arrow.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <osg/Geometry>

#include "viewer/arrays.h"
#include "viewer/arrow_parts.h"

namespace palp {
namespace {

constexpr int kSegments = 72, kSides = 10;
constexpr double kWholeBend = 300 * M_PI / 180;
constexpr double kThickness = 0.06;  // radius of the tube over that of the bend
constexpr double kHeadRadius = 0.17, kHeadLength = 0.38;
constexpr double kLeastShare = 0.08;  // a head without a bend is no arrow

// A tube of radius kThickness around a circle of radius 1 about z, from x on, its triangles in the order of the bend.
osg::ref_ptr<osg::Geometry> tube(osg::DrawArrays* triangles, const osg::Vec4f& color) {
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array;
  const auto add = [&](int segment, int side) {
    const double a = kWholeBend * segment / kSegments, b = 2 * M_PI * side / kSides;
    const osg::Vec3d out(std::cos(a), std::sin(a), 0), up(0, 0, 1);
    const osg::Vec3d normal = out * std::cos(b) + up * std::sin(b);
    vertices->push_back(out + normal * kThickness);
    normals->push_back(normal);
  };
  for (int segment = 0; segment < kSegments; ++segment) {
    for (int side = 0; side < kSides; ++side) {
      for (const auto& [s, t] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}) add(segment + s, side + t);
    }
  }
  osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
  geometry->setUseVertexBufferObjects(true);
  geometry->setVertexArray(vertices);
  geometry->setNormalArray(normals, osg::Array::BIND_PER_VERTEX);
  geometry->setColorArray(array_of<osg::Vec4Array>({color}), osg::Array::BIND_OVERALL);
  geometry->addPrimitiveSet(triangles);
  geometry->setCullingActive(false);
  return geometry;
}

}  // namespace

TorqueArrow::TorqueArrow(const osg::Vec4f& color)
    : pose_(new osg::MatrixTransform), head_(new osg::MatrixTransform), bend_(new osg::DrawArrays(GL_TRIANGLES, 0, 0)) {
  pose_->addChild(tube(bend_, color));
  const std::array<osg::Vec2f, 3> cone{osg::Vec2f(0, 0), osg::Vec2f(kHeadRadius, 0), osg::Vec2f(0, kHeadLength)};
  head_->addChild(revolve(cone, color));
  pose_->addChild(head_);
  root_ = seen_and_hidden(pose_);
  hide();
}

void TorqueArrow::set(const osg::Vec3d& origin, const osg::Vec3d& torque, double share, double radius) {
  const bool drawable = origin.valid() && torque.valid() && std::isfinite(share) && share > kLeastShare &&
                        std::isfinite(radius) && radius > 0 && torque.length2() > 0;
  if (!drawable) {
    hide();
    return;
  }
  root_->setNodeMask(~0u);
  const int segments = std::clamp(static_cast<int>(std::lround(share * kSegments)), 1, kSegments);
  bend_->setCount(segments * kSides * 6);
  bend_->dirty();
  const double end = kWholeBend * segments / kSegments;
  // from the x axis, where the tube begins, along the circle
  head_->setMatrix(osg::Matrixd::rotate(osg::Vec3d(0, 0, 1), osg::Vec3d(0, 1, 0)) * osg::Matrixd::translate(1, 0, 0) *
                   osg::Matrixd::rotate(end, osg::Vec3d(0, 0, 1)));
  pose_->setMatrix(osg::Matrixd::scale(radius, radius, radius) * osg::Matrixd::rotate(osg::Vec3d(0, 0, 1), torque) *
                   osg::Matrixd::translate(origin));
}

}  // namespace palp
