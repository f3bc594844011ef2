// The liquids and soft bodies of a scene as one view of it draws them: surfaces, whose passes and textures have the
// size of its picture. The particles are the scene's, for all of its views.
#pragma once

#include <array>
#include <memory>

#include <osg/Group>
#include <osg/Matrixd>
#include <osg/ref_ptr>

#include "viewer/medium_surface.h"
#include "viewer/wall_depths.h"

namespace palp {

class SceneGraph;

// A picture that is about to be drawn.
struct PictureView {
  int width = 1, height = 1;      // [pixels]
  bool quick = false;             // the surfaces of media must be cheap
  bool whole = false;             // they have a texel for each pixel, whatever that costs
  bool draws_shadows = true;      // false: they are as another view has drawn them
  osg::Matrixd view, projection;  // of the camera
};

// All calls from the thread that renders, between frames.
class MediaView {
 public:
  // scene: outlives the view.
  explicit MediaView(SceneGraph& scene);
  // To be drawn beside the scene's own root.
  osg::Node* node() { return root_; }
  // Takes what the camera sees of the scene as it is now: media are looked for where they can be.
  void set_view(const PictureView& picture);

 private:
  const SceneGraph& scene_;
  osg::ref_ptr<osg::Group> root_;
  osg::ref_ptr<PictureCopy> copy_;  // behind clear media
  WallDepths walls_;
  std::array<std::unique_ptr<MediumSurface>, 2> surfaces_;
  SurfaceQuality quality_;
};

}  // namespace palp
