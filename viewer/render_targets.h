// Passes that draw into textures before the picture is drawn, and a copy of the picture so far.
#pragma once

#include <osg/Camera>
#include <osg/Drawable>
#include <osg/Geometry>
#include <osg/Texture2D>
#include <osg/ref_ptr>

namespace palp {

// Texels of floats without interpolation between them. format: GL_RG32F_ARB and the like.
osg::ref_ptr<osg::Texture2D> float_texture(GLenum internal_format, GLenum format);

// A pass that draws its children into the texture before the picture, with the camera of the picture. Passes go by
// order. It clears to zero, and has a depth buffer of its own if it says so.
osg::ref_ptr<osg::Camera> pass_into(osg::Texture2D* texture, int order, bool with_depth);

// Makes a pass and its texture this large. All textures of a pass are attached to it alone.
void resize_pass(osg::Camera& pass, osg::Texture2D& texture, int width, int height);

// A geometry, empty at first, that is drawn in strips of its target where pictures are drawn in pieces (gpu_pacing.h).
osg::ref_ptr<osg::Geometry> geometry_in_strips();

// A rectangle over the whole target, for a vertex shader that takes its corners as they are.
osg::ref_ptr<osg::Geometry> screen_rectangle();

// Copies what has been drawn of the picture, colour and depth, when its turn to be drawn comes.
class PictureCopy : public osg::Drawable {
 public:
  PictureCopy();
  osg::Texture2D* color() const { return color_; }
  osg::Texture2D* depth() const { return depth_; }
  void set_size(int width, int height);

  osg::BoundingBox computeBoundingBox() const override { return {}; }
  void drawImplementation(osg::RenderInfo& info) const override;
  osg::Object* cloneType() const override { return new PictureCopy; }
  osg::Object* clone(const osg::CopyOp& /*unused*/) const override { return new PictureCopy; }

 private:
  osg::ref_ptr<osg::Texture2D> color_, depth_;
};

}  // namespace palp
