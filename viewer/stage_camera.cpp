// The camera of the stage and the places of its picture.
#include <algorithm>
#include <cmath>

#include <osgGA/OrbitManipulator>

#include "viewer/follow.h"
#include "viewer/home_view.h"
#include "viewer/stage.h"

namespace palp {
namespace {

osgGA::OrbitManipulator& orbit_of(osgViewer::Viewer& viewer) {
  return static_cast<osgGA::OrbitManipulator&>(*viewer.getCameraManipulator());
}

}  // namespace

void Stage::go_home() {
  // as if the free part were the whole picture, then moved into it
  const double free = std::max(width() - taken_right_, 0.3 * width());
  CameraPose pose = home_view(scene_->outline(), free / height());
  const osg::Vec3d along = pose.center - pose.eye;
  osg::Vec3d right = along ^ osg::Vec3d(0, 0, 1);
  right.normalize();
  const double visible = 2 * along.length() * std::tan(osg::DegreesToRadians(0.5 * kFieldOfView)) / height();
  const osg::Vec3d aside = right * (0.5 * (width() - free) * visible);
  auto* manipulator = viewer_->getCameraManipulator();
  manipulator->setAutoComputeHomePosition(false);
  manipulator->setHomePosition(pose.eye + aside, pose.center + aside, osg::Vec3d(0, 0, 1));
  manipulator->home(0);
  home_ = manipulator->getMatrix();
  field_of_view_ = kFieldOfView;
}

void Stage::set_camera(const CameraPose& pose, double field_of_view) {
  auto* manipulator = viewer_->getCameraManipulator();
  manipulator->setHomePosition(pose.eye, pose.center, osg::Vec3d(0, 0, 1));
  manipulator->home(0);
  field_of_view_ = field_of_view;
}

void Stage::set_taken_right(double pixels) {
  if (pixels == taken_right_) return;
  taken_right_ = pixels;
  go_home_unless_moved();
}

StoredView Stage::view() const {
  StoredView view;
  orbit_of(*viewer_).getTransformation(view.eye, view.center, view.up);
  return view;
}

void Stage::set_view(const StoredView& view) {
  const osg::Vec3d along = view.center - view.eye;
  if (!((along ^ view.up).length() > 1e-9 * along.length())) return;
  orbit_of(*viewer_).setTransformation(view.eye, view.center, view.up);
}

void Stage::follow_tools(double seconds) {
  if (!following_) return;
  const std::vector<osg::Vec3d> corners = scene_->tools();
  if (corners.empty()) return;
  osgGA::OrbitManipulator& orbit = orbit_of(*viewer_);
  orbit.setCenter(followed(orbit.getCenter(), middle_of(corners), seconds));
}

void Stage::toggle_full_screen() {
  if (window_place_[2] > 0) {
    window_->setWindowDecoration(true);
    window_->setWindowRectangle(window_place_[0], window_place_[1], window_place_[2], window_place_[3]);
    window_place_ = {};
    return;
  }
  auto* windows = osg::GraphicsContext::getWindowingSystemInterface();
  if (windows == nullptr || !window_->getTraits()->windowDecoration) return;  // off-screen
  unsigned width = 0, height = 0;
  windows->getScreenResolution(*window_->getTraits(), width, height);  // of the display that the window is on
  if (width == 0 || height == 0) return;
  window_->getWindowRectangle(window_place_[0], window_place_[1], window_place_[2], window_place_[3]);
  window_->setWindowDecoration(false);
  window_->setWindowRectangle(0, 0, static_cast<int>(width), static_cast<int>(height));
}

osg::Vec2d Stage::project(const osg::Vec3d& point) const {
  const osg::Camera* camera = viewer_->getCamera();
  const osg::Vec3d ndc = point * (camera->getViewMatrix() * camera->getProjectionMatrix());
  return {0.5 * (ndc.x() + 1) * width(), 0.5 * (ndc.y() + 1) * height()};
}

Ray Stage::ray_through(const osg::Vec2d& place) const {
  const osg::Camera* camera = viewer_->getCamera();
  const osg::Matrixd to_world = osg::Matrixd::inverse(camera->getViewMatrix() * camera->getProjectionMatrix());
  const double x = 2 * place.x() / width() - 1, y = 2 * place.y() / height() - 1;
  const osg::Vec3d near = osg::Vec3d(x, y, -1) * to_world, far = osg::Vec3d(x, y, 1) * to_world;
  Ray ray{near, far - near};
  ray.direction.normalize();
  return ray;
}

double Stage::pixels_of(double length, const osg::Vec3d& at) const {
  const osg::Camera* camera = viewer_->getCamera();
  const double depth = -(at * camera->getViewMatrix()).z();
  return depth > 0 ? 0.5 * height() * camera->getProjectionMatrix()(1, 1) * length / depth : 0;
}

}  // namespace palp
