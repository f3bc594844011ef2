// The camera that figures and timelines are drawn with, over the picture.
#pragma once

#include <osg/BlendFunc>
#include <osg/Camera>
#include <osg/ref_ptr>

namespace palp {

// A camera that draws its children over the picture in the order of the tree: panels below, words above. Those of a
// higher order come later. Who makes it sets its projection.
inline osg::ref_ptr<osg::Camera> overlay_camera(int order) {
  osg::ref_ptr<osg::Camera> camera = new osg::Camera;
  camera->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
  camera->setRenderOrder(osg::Camera::POST_RENDER, order);
  camera->setClearMask(0);
  camera->setViewMatrix(osg::Matrixd::identity());
  camera->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
  camera->setCullingActive(false);
  camera->setAllowEventFocus(false);
  osg::StateSet* state = camera->getOrCreateStateSet();
  state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
  state->setMode(GL_DEPTH_TEST, osg::StateAttribute::OFF);
  state->setAttributeAndModes(new osg::BlendFunc(osg::BlendFunc::SRC_ALPHA, osg::BlendFunc::ONE_MINUS_SRC_ALPHA));
  state->setRenderBinDetails(0, "TraversalOrderBin");
  state->setNestRenderBins(false);
  return camera;
}

}  // namespace palp
