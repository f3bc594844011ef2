// Particles as shaded spheres on point sprites.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <osg/Geometry>
#include <osg/Switch>
#include <osg/Texture1D>
#include <osg/ref_ptr>

#include "idl/messages.h"
#include "idl/particle_frame.h"
#include "viewer/color_map.h"

namespace palp {

// All calls from the thread that renders, between frames. Three sets of arrays take turns, so that a driver never waits
// for a buffer that the last frame still reads.
class ParticleCloud {
 public:
  ParticleCloud();
  osg::Node* node() { return switch_; }

  // Takes over the size of the particles, their bodies and colours. Nothing is drawn until the next frame.
  void set_scene(const SceneDescription& scene);
  // Draws also those of bodies that have a surface, from the next frame on.
  void set_draw_all(bool all) { draw_all_ = all; }
  // Frames may come with any number of particles; those that no body of the scene claims are not drawn.
  void set_frame(const ParticleFrame& frame);
  void clear();
  // Takes the height of the picture [pixels]: sprites are sized in pixels.
  void set_picture_height(int height);

  // none: by body. A field that the frames do not carry is shown by body too: see shown_field(). So are solids that do
  // not deform when density or pressure is shown, as they have neither.
  void set_color(ScalarField field) { wanted_ = field; }
  ScalarField shown_field() const { return shown_; }
  const ValueRange& range() const { return range_; }
  std::size_t drawn() const { return drawn_; }

 private:
  static constexpr std::size_t kSets = 3;
  struct Body {  // a BodyDescription without its surface
    BodyKind kind;
    std::uint32_t first, count;  // of its particles
    double density;              // at rest [kg/m^3]
    std::array<float, 3> color;
    bool has_surface;
  };

  void choose_colors(const ParticleFrame& frame);
  std::vector<float> values_for_range(const ParticleFrame& frame) const;
  void choose_runs(std::size_t count);

  osg::ref_ptr<osg::Switch> switch_;
  std::array<osg::ref_ptr<osg::Geometry>, kSets> sets_;
  osg::ref_ptr<osg::Texture1D> map_;
  ColorMapKind map_kind_ = ColorMapKind::sequential;
  std::vector<Body> bodies_;
  bool draw_all_ = false;
  double rest_density_ = 0;
  std::size_t next_ = 0;
  std::size_t drawn_ = 0;
  ScalarField wanted_ = ScalarField::none;
  ScalarField shown_ = ScalarField::none;
  SteadyRange steady_;
  ValueRange range_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> runs_;  // first, count of the particles drawn
};

}  // namespace palp
