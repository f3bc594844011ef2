// A scene sampled into particles and bodies: the host's input to the simulation. Double precision; the back end rounds.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "config/scene_config.h"
#include "sim_server/geometry/point_grid.h"
#include "sim_server/geometry/surface_mesh.h"

namespace palp {

struct ContactShape;

struct Body {
  std::string name;
  BodyKind type = BodyKind::fluid;
  std::uint32_t material = 0;  // index into Scene::config.materials
  std::uint32_t first = 0;     // particles [first, first + count)
  std::uint32_t count = 0;
  std::uint32_t sites = 0;  // particles that fill its shape at the scene's spacing, left out or not
  double volume = 0;        // exact volume of the shape [m^3]
  double mass = 0;          // [kg]
  Eigen::Vector3d center = Eigen::Vector3d::Zero();       // centre of mass in the body frame [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();  // about the centre of mass, body axes [kg m^2]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();     // of the body frame in the world, at the start [m]
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  // The axes of the lattice that its particles lie on, in the body frame; unset: they lie anyhow.
  std::optional<Eigen::Quaterniond> lattice = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // of the centre of mass [m/s]
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // world axes [rad/s]
  bool holds_temperature = false;                              // of each of its particles, as at the start
  std::optional<double> temperature;                           // of all of it at the start [K]; unset: it has none, or
                                                               // each of its particles its own
  std::vector<std::uint32_t> bonded_to;                        // of an elastic body: bodies it holds on to
  std::array<float, 3> color{};                                // sRGB
  Look look;
  std::array<float, 3> changed_color{};  // of its matter that has changed state
  Look changed_look;
  SurfaceMesh surface;  // of a rigid or fixed body, unless it is of loose particles
  SurfaceMesh skin;     // likewise, of an elastic body at rest, for the viewer alone
  // The shape that rigid_contact.h needs (contact_shape.h); none for fluids, elastic bodies, loose particles, method
  // "paper", and where no solid moves that could meet another.
  std::shared_ptr<const ContactShape> contact;
  // The box around the centres of the particles that fill it, or around its surface where it is too thin for particles,
  // along the body's axes [m]; empty where none is left out.
  Eigen::AlignedBox3d extent;
};

struct Proxy {
  std::uint32_t device = 0;
  std::uint32_t body = 0;                            // index into Scene::bodies, a rigid one
  Eigen::Vector3d handle = Eigen::Vector3d::Zero();  // coupling point in the body frame [m]
  CouplingGains limit = kDefaultGains;
};

// The facts that the plan asks of the particles of rigid and fixed bodies, of a scene that leaves some of them out.
struct LeftOut {
  double speed = 0;  // largest of them at the start [m/s]
  std::array<std::array<double, 2>, 3>
      fall{};  // fall_height() of fluids, or else rigid bodies, by axis, for up = -1 and 1 [m]
};

// Particles in the scene's order: body after body. World frame.
struct Scene {
  SceneConfig config;
  double spacing = 0;  // dx [m]
  std::vector<Body> bodies;
  std::vector<Proxy> proxies;
  std::vector<Eigen::Vector3d> position;                 // [m]
  std::vector<Eigen::Vector3d> velocity;                 // [m/s]
  std::vector<double> volume;                            // rest volume [m^3]
  std::vector<std::uint32_t> body;                       // index into bodies
  std::vector<double> temperature;                       // [K]; empty when no body has one
  Eigen::Vector3d bounds_min = Eigen::Vector3d::Zero();  // of the domain
  Eigen::Vector3d bounds_max = Eigen::Vector3d::Zero();
  std::optional<LeftOut> left_out;  // none: every body has its particles
  bool runs_off = false;            // a fluid has nothing beside or beneath it (open_sides.h)
};

// Returns the scene's domain.
inline PeriodicBox box_of(const Scene& scene) { return {scene.bounds_min, scene.bounds_max, scene.config.periodic}; }

// Returns what takes a place of a body's frame into the world, at the start.
inline Eigen::Isometry3d pose_of(const Body& body) { return Eigen::Translation3d(body.position) * body.orientation; }

// Returns the material of a body of the scene.
inline const MaterialConfig& material_of(const Scene& scene, const Body& body) {
  return scene.config.materials[body.material];
}

// Takes what is being done and which share of it is done, 0 to 1, now and then; called by the thread that loads.
using LoadingProgress = std::function<void(const char* doing, double share)>;

// Samples the scene's bodies at the spacing that the accuracy level gives. Throws ConfigError with every fault found:
// open or missing mesh, overlapping bodies, a body or shape without particles, a particle outside the domain, more
// particles than max_particles (what memory allows). Bodies that need no particles (particle_reason.h) are checked with
// theirs and then have none.
Scene sample_scene(const SceneConfig& config, std::size_t max_particles, const LoadingProgress& progress = {});

}  // namespace palp
