// The particles of opaque or of clear media as one smooth surface, found in the picture: the distance of the particles
// is drawn into a texture, smoothed there, and shaded in the picture.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <osg/BoundingBox>
#include <osg/Camera>
#include <osg/Group>
#include <osg/Matrixd>
#include <osg/Scissor>
#include <osg/Texture1D>
#include <osg/Texture2D>
#include <osg/ref_ptr>

#include "viewer/medium.h"
#include "viewer/render_targets.h"

namespace palp {

// The cost of the passes.
struct SurfaceQuality {
  double scale = 1;    // texels of the surface a pixel of the picture, along each side
  int rounds = 2;      // of smoothing, each along both axes
  int most_taps = 24;  // of the filter to each side
  int clean_taps = 3;
  int outline_taps = 16;  // to each side
  bool operator==(const SurfaceQuality&) const = default;
};

// Returns what suits a GPU, given the spacing of particles in the middle of the picture [pixels]: where they are large,
// half the texels show as much. now: what was used so far; it stays as long as it does.
SurfaceQuality fine_surface(double spacing_pixels, const SurfaceQuality& now);
// Returns what a rasteriser on a CPU can do for a picture of this size: each texel counts.
SurfaceQuality quick_surface(int width, int height);

// All calls from the thread that renders, between frames.
class MediumSurface {
 public:
  // medium: opaque or clear. particles, tinting: points as medium.vert takes them, those that make the surface and
  // those that give it its tint. copy: of the picture behind a clear medium. walls: those that end it (wall_depths.h).
  MediumSurface(Medium medium, osg::Node* particles, osg::Node* tinting, osg::Texture1D* color_map,
                const PictureCopy* copy, osg::Texture2D* walls);
  osg::Node* node() { return root_; }

  void set_spacing(double spacing);  // of the particles [m]
  // Takes whether colours stand for numbers, and the look that all of the medium has; without one looks are drawn
  // particle by particle.
  void set_colors(bool by_scalar, const std::optional<OneTint>& tint);
  // Takes whether the surface goes on into walls that are to end it. They have a texel a pixel.
  void set_ended_by_walls(bool ended);
  // The size of the picture [pixels].
  void set_size(int width, int height, const SurfaceQuality& quality);
  // Confines the work to where the box of the particles is seen. An invalid box: nothing is drawn.
  void set_seen(const osg::BoundingBoxd& box, const osg::Matrixd& view, const osg::Matrixd& projection);

 private:
  struct Share {  // of the picture, 0 .. 1
    double low[2] = {0, 0}, high[2] = {1, 1};
  };
  struct Pass {
    osg::ref_ptr<osg::Camera> camera;
    osg::ref_ptr<osg::Texture2D> texture;
    osg::ref_ptr<osg::Scissor> scissor;
    double share = 1;  // of the surface's size
  };

  Pass& add_pass(GLenum internal_format, GLenum format, bool with_depth, double share);
  void add_depth_pass(osg::Node* particles);
  void add_tint_pass(osg::Node* particles);
  void add_outline_passes();
  void make_smoothing();
  void choose_formats();
  static void confine(osg::Scissor& scissor, const Share& to, double width, double height);
  void make_shading(osg::Texture1D* color_map, const PictureCopy* copy);

  Medium medium_;
  osg::ref_ptr<osg::Group> root_;
  osg::ref_ptr<osg::Group> smoothing_;  // its passes follow the quality
  osg::ref_ptr<osg::Geometry> shading_;
  osg::ref_ptr<osg::Texture2D> surface_looks_;  // beside the tints
  osg::ref_ptr<osg::Texture2D> walls_;
  osg::ref_ptr<osg::Program> tint_program_, thickness_program_;
  std::vector<Pass> passes_;  // depth, tint, outline along both axes, then those of the smoothing
  double spacing_ = 0;        // [m]
  bool by_scalar_ = false;
  bool one_tint_ = false;
  int width_ = 0, height_ = 0;
  SurfaceQuality quality_;
  Share drawn_;  // where the passes of the smoothing may have something of the last picture
  osg::ref_ptr<osg::Scissor> picture_scissor_;
};

}  // namespace palp
