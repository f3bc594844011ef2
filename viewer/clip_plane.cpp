#include "viewer/clip_plane.h"

#include <algorithm>

namespace palp {
namespace {

// The side that is kept: the far one as the home view sees it.
constexpr double kKeptSide[] = {-1, 1, -1};

}  // namespace

double position_of(const ClipPlane& clip, const osg::BoundingBoxd& box) {
  const double low = box._min[clip.axis], high = box._max[clip.axis];
  return low + std::clamp(clip.share, 0.0, 1.0) * (high - low);
}

double share_at(double position, int axis, const osg::BoundingBoxd& box) {
  const double low = box._min[axis], size = box._max[axis] - low;
  return size > 0 ? std::clamp((position - low) / size, 0.0, 1.0) : 0.5;
}

osg::Vec4d equation_of(const ClipPlane& clip, const osg::BoundingBoxd& box) {
  if (!clip.on || !box.valid()) return kNoClip;
  const double side = kKeptSide[clip.axis] * (clip.flipped ? -1 : 1);
  osg::Vec4d equation(0, 0, 0, -side * position_of(clip, box));
  equation[clip.axis] = side;
  return equation;
}

}  // namespace palp
