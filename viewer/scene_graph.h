// Everything that is drawn of a scene, from plain messages, for any number of views; only the surfaces of media are
// each view's own (media_view.h). All calls from the thread that renders, between frames.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <osg/BoundingBox>
#include <osg/Group>
#include <osg/MatrixTransform>
#include <osg/ref_ptr>

#include "idl/messages.h"
#include "viewer/hand_view.h"
#include "viewer/media_view.h"
#include "viewer/mesh.h"
#include "viewer/particle_cloud.h"
#include "viewer/shadow_map.h"
#include "viewer/soft_surface.h"
#include "viewer/touch_view.h"

namespace palp {

class SceneGraph {
 public:
  SceneGraph();
  osg::Group* root() { return root_; }

  // Drops all that belongs to the scene before. Its surfaces come with set_surface().
  void set_scene(const SceneDescription& scene);
  // Shows the surface of a body, where the poses so far have put it. Fixed bodies stand at their own frame until a pose
  // names them, rigid ones are hidden until one does. A body that the scene lacks is passed over.
  void set_surface(std::size_t body, const BodyMesh& mesh);
  // Shows the surface of a soft body from the next frame on, where its particles carry it. A body that the scene lacks
  // is passed over. mesh.solid: the surface at rest, whose vertices the skin has.
  void set_soft_surface(std::size_t body, const BodyMesh& mesh, Skin skin);
  // Draws nothing: there is no server yet.
  void clear();
  // earlier: as ParticleCloud takes it.
  void set_frame(const ParticleFrame& frame, const ParticleFrame* earlier = nullptr);
  // Poses of bodies that the scene lacks, and poses that are no poses, are passed over.
  void set_poses(const BodyPoses& poses);
  // Draws what the hand feels at the proxy's handle. Devices from kMaxDevices on are passed over.
  void set_proxy(const ProxySample& sample);

  // Nothing is known of the hand. device below kMaxDevices.
  void hide_proxy(std::uint32_t device) { hands_[device]->hide(); }
  // Writes this force and torque beside the arrows of a device below kMaxDevices, until it is told anew.
  void set_values(std::uint32_t device, const WrenchD& wrench) { hands_[device]->set_values(wrench); }
  void set_values_shown(bool shown);
  const HandView& hand(std::uint32_t device) const { return *hands_[device]; }
  // Makes it ready for the next picture, in whichever view that is.
  void set_view(const PictureView& picture);
  void set_color(ScalarField field) { cloud_.set_color(field); }
  // Takes over how colours are read and where the scene is cut open: surfaces at once, particles from the next frame
  // on.
  void set_reading(const Reading& reading);
  // Returns the plane that the scene is cut open with (clip_plane.h).
  const osg::Vec4d& clip() const { return clip_; }
  // Draws the particles of every body instead of surfaces, from the next frame on.
  void set_draw_all(bool all);
  // Draws the particles of media as beads and not as surfaces, from the next frame on.
  void set_beads(bool beads) { cloud_.set_beads(beads); }

  // Takes where the arms' handles can be moved, by device.
  void set_reaches(const std::map<std::uint32_t, HandReach>& reaches);
  // Marks where media touch tools (touch_marks.h), from the next frame on.
  void set_touch_marked(bool marked) { touch_.set_marked(marked); }
  // Returns how much of all tools is touched in the newest frame; nothing while that is not marked, or no tool is held.
  const std::optional<Touch>& touch() const { return touch_.touch(); }

  ParticleCloud& cloud() { return cloud_; }
  const ParticleCloud& cloud() const { return cloud_; }
  double spacing() const { return spacing_; }  // of the particles [m]
  // Returns the hollow solids that one looks through, for WallDepths.
  osg::Group* hollow_walls() const { return hollow_walls_; }
  // Returns the box around the surfaces and the first frame; the domain's bounds before there is either.
  const osg::BoundingBoxd& content() const { return content_; }
  // Points all over what content() is around: enough of them to frame it.
  const std::vector<osg::Vec3d>& outline() const { return outline_; }
  // The corners of the tools that hands hold, where they are now and within the domain.
  std::vector<osg::Vec3d> tools() const;
  // Returns where the body's frame stands, or nothing while it is not shown or where the scene has no such body.
  std::optional<osg::Matrixd> body_pose(std::size_t body) const;
  // Returns the box around the body's surface in its own frame; invalid where it has none.
  osg::BoundingBox body_box(std::size_t body) const {
    return body < bodies_.size() ? bodies_[body].box : osg::BoundingBox();
  }
  // Adds points to the outline until the next scene.
  void widen_outline(const std::vector<osg::Vec3d>& points);
  // The force [N] and length [m] of the longest arrow.
  double arrow_force() const { return force_scale_.full_scale(); }
  double arrow_length() const { return 0.55 * content_.radius(); }

 private:
  struct PlacedBody {
    BodyKind kind = BodyKind::fluid;
    Look look;
    std::uint32_t first = 0, count = 0;  // of its particles
    osg::BoundingBox box;                // of the surface, body frame
    std::vector<osg::Vec3d> outline;     // points of it, body frame
    osg::ref_ptr<osg::MatrixTransform> place;
    osg::ref_ptr<osg::MatrixTransform> wall;  // of a hollow one that is looked through
    std::shared_ptr<const MirrorImages> images;
    std::unique_ptr<SoftSurface> soft;
  };

  void add_shadows();
  std::vector<StandingSolid> standing_solids() const;
  void follow_particles(const ParticleFrame& frame);
  void update_content();
  void place_ground();
  void cut_open();
  static constexpr double kSmallestTorque = 0.02;  // [N m]

  osg::ref_ptr<osg::Group> root_;
  osg::ref_ptr<osg::Group> surfaces_;
  osg::ref_ptr<osg::StateSet> solid_, glass_, edges_;
  osg::ref_ptr<osg::Group> hollow_walls_;  // where media end that are seen through them
  osg::ref_ptr<osg::Geometry> ground_;
  ParticleCloud cloud_;
  ShadowMap shadow_map_;
  std::vector<PlacedBody> bodies_;
  std::array<std::unique_ptr<HandView>, kMaxDevices> hands_;
  std::vector<ProxyDescription> proxies_;  // of devices below kMaxDevices
  TouchView touch_;
  ForceScale force_scale_, torque_scale_{kSmallestTorque};
  osg::BoundingBoxd domain_;
  osg::BoundingBoxd first_frame_;          // the box around its particles; invalid before it comes
  std::vector<osg::Vec3d> first_outline_;  // points of it
  std::vector<osg::Vec3d> roamed_;         // where tools have been out of the picture
  osg::BoundingBoxd content_;
  std::vector<osg::Vec3d> outline_;
  bool seen_frame_ = false;
  Reading reading_;
  osg::Vec4d clip_ = kNoClip;
  double spacing_ = 0;  // of the particles [m]
};

}  // namespace palp
