// The camera that shows a whole scene.
#pragma once

#include <span>

#include <osg/Vec3d>

namespace palp {

inline constexpr double kFieldOfView = 30;  // vertical [degrees]

// The way from a scene to the eye that has the home view of it.
inline const osg::Vec3d kHomeSide(0.36, -0.82, 0.46);

// A camera: where it stands and the point that it looks at, world z up.
struct CameraPose {
  osg::Vec3d eye;
  osg::Vec3d center;
};

// Returns the nearest view from the front, the right and above that shows all of the points with a margin, at least one
// of them. aspect: width over height.
CameraPose home_view(std::span<const osg::Vec3d> points, double aspect);

}  // namespace palp
