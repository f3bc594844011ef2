// The shadows of the key light: what it sees, as a texture of depths that the shading compares with.
#pragma once

#include <osg/BoundingBox>
#include <osg/Camera>
#include <osg/Group>
#include <osg/Matrixd>
#include <osg/Texture2D>
#include <osg/ref_ptr>

namespace palp {

// The texture unit that the map has in every program that shades.
inline constexpr unsigned kShadowUnit = 7;
// Nodes without this bit in their mask cast no shadow.
inline constexpr unsigned kCastsShadow = 1u << 1;

// Calls from the thread that renders, between frames.
class ShadowMap {
 public:
  ShadowMap();
  osg::Node* node() { return camera_; }
  // Adds what casts shadows: surfaces, or points as medium.vert takes them.
  void add_surfaces(osg::Node* surfaces);
  void add_points(osg::Node* points);
  // Gives programs below this state the map.
  void give_to(osg::StateSet& state);

  void set_spacing(double spacing);  // of the points' particles [m]
  void set_size(int texels);         // along each side
  // Leaves out what lies beyond the plane (clip_plane.h) of the surfaces that are cut open.
  void set_clip(const osg::Vec4d& equation);
  // Lights the box for a picture with this view.
  void set_view(const osg::BoundingBoxd& box, const osg::Matrixd& view);

 private:
  osg::ref_ptr<osg::Camera> camera_;
  osg::ref_ptr<osg::Texture2D> depth_;
  osg::ref_ptr<osg::Group> points_;
  osg::ref_ptr<osg::Uniform> from_eye_, texel_;
  int texels_ = 0;
};

}  // namespace palp
