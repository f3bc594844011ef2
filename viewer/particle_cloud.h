// The particles on the GPU, as points that beads and surfaces of media are drawn from.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <osg/BoundingBox>
#include <osg/Geometry>
#include <osg/Matrixd>
#include <osg/Switch>
#include <osg/Texture1D>
#include <osg/ref_ptr>

#include "idl/messages.h"
#include "idl/particle_frame.h"
#include "viewer/color_map.h"
#include "viewer/front_to_back.h"
#include "viewer/interior.h"
#include "viewer/look_table.h"
#include "viewer/medium.h"
#include "viewer/mirror_images.h"
#include "viewer/reading.h"
#include "viewer/skin.h"
#include "viewer/spray_view.h"
#include "viewer/streamed_array.h"

namespace palp {

// A solid where it stands.
struct StandingSolid {
  std::shared_ptr<const MirrorImages> images;
  osg::Matrixd pose;
};

// All calls from the thread that renders, between frames. Three sets of arrays take turns, so that a driver never waits
// for a buffer that the last frame still reads.
class ParticleCloud {
 public:
  ParticleCloud();
  // The points drawn as this medium, but for those that others of their body hide; those of Medium::beads draw
  // themselves as shaded spheres.
  osg::Node* points(Medium medium) { return switches_[static_cast<std::size_t>(medium)]; }
  // The inside of bodies that are looked through, lump by lump, as medium.vert takes it.
  osg::Node* clear_lumps() { return lumps_switch_; }
  // The drops that liquids fly apart into.
  osg::Node* spray() { return spray_.node(); }
  osg::Texture1D* color_map_texture() { return map_; }
  // The state that passes over points of every medium need: colours by scalar.
  osg::StateSet* shared_state() { return shared_; }

  // Takes over the size of the particles, their bodies and colours. Nothing is drawn until the next frame.
  void set_scene(const SceneDescription& scene);
  // Draws also those of bodies that have a surface, all as beads, from the next frame on.
  void set_draw_all(bool all) { draw_all_ = all; }
  // Returns whether surfaces that particles carry along may stand for them when this frame is set: they have no colours
  // by numbers, and nothing within.
  bool takes_skins(const ParticleFrame& frame) const;
  // From the next frame on a surface stands for the particles of this body of the scene, but for those that are bare.
  // skin: stays where it is for as long; null: none does.
  void set_skin(std::size_t body, const Skin* skin) { bodies_[body].skin = skin; }
  // Draws media as beads, from the next frame on.
  void set_beads(bool beads) { beads_ = beads; }
  // Takes the solids that particles touch, from the next frame on: mirror images of media are drawn with them, but for
  // beads, and not while the scene is cut open.
  void set_solids(std::vector<StandingSolid> solids) { solids_ = std::move(solids); }
  // Frames may come with any number of particles; those that no body of the scene claims are not drawn. earlier: the
  // frame a little before, which says how fast particles are; null: they are taken to rest.
  void set_frame(const ParticleFrame& frame, const ParticleFrame* earlier = nullptr);
  void clear();
  // Takes the height of the picture [pixels]: sprites are sized in pixels.
  void set_picture_height(int height);

  // none: by body. A field that the frames do not carry is shown by body too: see shown_field(). So are solids that do
  // not deform when density or pressure is shown, as they have neither.
  void set_color(ScalarField field) { wanted_ = field; }
  // Takes the map and the range of colours, and (n, d) of the plane beyond which particles are left out: those that are
  // kept have n . p + d >= 0. All from the next frame on.
  void set_reading(const Reading& reading, const osg::Vec4d& clip);
  ScalarField shown_field() const { return shown_; }
  const ValueRange& range() const { return range_; }
  ColorMapKind color_map_kind() const { return map_kind_; }
  // The particles of bodies that are drawn as particles, hidden or not.
  std::size_t drawn() const { return drawn_; }
  // Those of them that others of their body do not hide.
  std::size_t seen() const { return seen_; }
  // Those of them that are drops, wholly or in part.
  std::size_t drops() const { return spray_.drops(); }
  // Returns the look of what is opaque, or of what is clear, where it has one alone, or none at all because colours
  // stand for numbers.
  std::optional<OneTint> one_tint(Medium medium) const;
  // The box around the points of the medium, invalid where there are none. Points that are no places, or farther out
  // than anything that is simulated, are not drawn.
  const osg::BoundingBoxd& box(Medium medium) const { return boxes_[static_cast<std::size_t>(medium)]; }

 private:
  static constexpr std::size_t kSets = 3;
  struct Body {  // a BodyDescription without its surface
    BodyKind kind;
    std::uint32_t first, count;  // of its particles
    double density;              // at rest [kg/m^3]
    bool has_surface;
    Medium medium;                   // as it usually looks
    bool foams;                      // it is a liquid that flies apart
    std::vector<osg::Vec4ub> tints;  // colour and row of looks_, from as it is at first to wholly changed
    const Skin* skin = nullptr;      // set_skin()
  };
  struct Set {
    osg::ref_ptr<StreamedArray<osg::Vec4Array>> vertices;
    osg::ref_ptr<StreamedArray<osg::Vec4ubArray>> colors;
    // of the same arrays
    std::array<osg::ref_ptr<osg::Geometry>, kMediums> points;
    osg::ref_ptr<osg::Geometry> clear_lumps;
  };

  bool carries_wanted(const ParticleFrame& frame) const;
  void choose_colors(const ParticleFrame& frame);
  std::vector<float> values_for_range(const ParticleFrame& frame) const;
  std::optional<Medium> medium_of(const Body& body) const;
  std::vector<osg::Vec4ub> tints_of(const BodyDescription& body, std::size_t stages);
  void find_seen(const Body& body, const ParticleFrame& frame);
  bool flies(const Body& body) const { return body.foams && shown_ == ScalarField::none && !beads_ && !draw_all_; }
  // Returns the values of a body's particles, so many each, as far as a frame has them.
  static std::span<const float> part_of(const Body& body, std::span<const float> values, std::size_t each);
  void let_fly(const Body& body, const ParticleFrame& frame, const ParticleFrame* earlier);
  void add_body(const Body& body, Medium medium, Set& set);
  void add_images(std::size_t from, Medium medium);
  void add_outer(Medium medium, Set& set);
  void add_within(const Body& body, Set& set);
  void note_tints(const Body& body, Medium medium);

  osg::ref_ptr<osg::StateSet> shared_;
  std::array<osg::ref_ptr<osg::Switch>, kMediums> switches_;
  osg::ref_ptr<osg::Switch> lumps_switch_;
  std::array<Set, kSets> sets_;
  osg::ref_ptr<osg::Texture1D> map_;
  LookTable looks_;
  ColorMapKind map_kind_ = ColorMapKind::sequential;
  std::vector<Body> bodies_;
  double spacing_ = 0;                   // [m]
  std::vector<osg::Vec4f> places_;       // of the body that is taken over: x, y, z and its scalar
  std::vector<unsigned char> stages_;    // of its matter, which of the body's tints; empty: all have the first
  std::vector<std::uint32_t> left_out_;  // of a body that flies, particles without a place
  Interior interior_;                    // of the places
  SprayView spray_;
  struct Outer {
    std::vector<osg::Vec4f> places;
    std::vector<osg::Vec4ub> tints;
  };
  std::array<Outer, kMediums> outer_;  // of all bodies of a medium what is not within
  std::vector<StandingSolid> solids_;
  FrontToBack front_to_back_;
  bool draw_all_ = false;
  bool beads_ = false;
  double rest_density_ = 0;
  std::size_t next_ = 0;
  std::size_t drawn_ = 0;
  std::size_t seen_ = 0;
  ScalarField wanted_ = ScalarField::none;
  ScalarField shown_ = ScalarField::none;
  SteadyRange steady_;
  Reading reading_;
  osg::Vec4d clip_ = kNoClip;
  ValueRange range_;
  std::array<osg::BoundingBoxd, kMediums> boxes_;
  std::array<std::vector<osg::Vec4ub>, kMediums> tints_;  // no two alike; those of what is clear without colours
};

}  // namespace palp
