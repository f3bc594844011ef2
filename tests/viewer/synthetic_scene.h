// A tray of fluid with a paddle in it, made from formulas: what a server would send, without one.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "config/looks.h"
#include "idl/messages.h"
#include "viewer/particle_cloud.h"

namespace palp::test {

inline constexpr double kSpacing = 0.008;                                                          // [m]
inline constexpr double kHalfX = 0.14, kHalfY = 0.09, kDepth = 0.05, kWall = 0.008, kRim = 0.075;  // of the tray [m]

// Makes a body look like what has that name (config/looks.h), in its own colour.
inline void make_look(BodyDescription& body, const char* name) {
  body.look = named_look(name).look;
  if (body.look.clear) body.look.absorption_per_m = absorption_of(body.color);
}

inline void add_quad(BodyDescription& body, const std::array<std::array<double, 3>, 4>& corners) {
  const auto base = static_cast<std::uint32_t>(body.vertices.size() / 3);
  for (const auto& c : corners) {
    for (const double x : c) body.vertices.push_back(static_cast<float>(x));
  }
  for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) body.triangles.push_back(base + k);
}

// A box from a to b; outward: seen from outside, else a cavity.
inline void add_box(BodyDescription& body, std::array<double, 3> a, std::array<double, 3> b, bool outward, bool top) {
  const auto side = [&](std::array<std::array<double, 3>, 4> q) {
    if (!outward) std::swap(q[1], q[3]);
    add_quad(body, q);
  };
  side({{{a[0], a[1], a[2]}, {b[0], a[1], a[2]}, {b[0], a[1], b[2]}, {a[0], a[1], b[2]}}});
  side({{{b[0], b[1], a[2]}, {a[0], b[1], a[2]}, {a[0], b[1], b[2]}, {b[0], b[1], b[2]}}});
  side({{{b[0], a[1], a[2]}, {b[0], b[1], a[2]}, {b[0], b[1], b[2]}, {b[0], a[1], b[2]}}});
  side({{{a[0], b[1], a[2]}, {a[0], a[1], a[2]}, {a[0], a[1], b[2]}, {a[0], b[1], b[2]}}});
  side({{{a[0], b[1], a[2]}, {b[0], b[1], a[2]}, {b[0], a[1], a[2]}, {a[0], a[1], a[2]}}});
  if (top) side({{{a[0], a[1], b[2]}, {b[0], a[1], b[2]}, {b[0], b[1], b[2]}, {a[0], b[1], b[2]}}});
}

// wall: how thick its walls are [m]
inline BodyDescription tray(double wall = kWall) {
  BodyDescription body;
  body.name = "tray";
  body.kind = BodyKind::fixed;
  body.color = {0.55f, 0.57f, 0.60f};
  const double x = kHalfX, y = kHalfY, X = x + wall, Y = y + wall;
  add_box(body, {-X, -Y, -wall}, {X, Y, kRim}, true, false);
  add_box(body, {-x, -y, 0}, {x, y, kRim}, false, false);
  add_quad(body, {{{-X, -Y, kRim}, {X, -Y, kRim}, {x, -y, kRim}, {-x, -y, kRim}}});
  add_quad(body, {{{X, -Y, kRim}, {X, Y, kRim}, {x, y, kRim}, {x, -y, kRim}}});
  add_quad(body, {{{X, Y, kRim}, {-X, Y, kRim}, {-x, y, kRim}, {x, y, kRim}}});
  add_quad(body, {{{-X, Y, kRim}, {-X, -Y, kRim}, {-x, -y, kRim}, {-x, y, kRim}}});
  return body;
}

// A blade on a round handle, standing; its frame's origin is the handle's point.
inline BodyDescription paddle() {
  BodyDescription body;
  body.name = "paddle";
  body.kind = BodyKind::rigid;
  body.color = {0.80f, 0.64f, 0.42f};
  add_box(body, {-0.028, -0.005, -0.095}, {0.028, 0.005, -0.035}, true, true);
  constexpr int kSides = 24;
  const double r = 0.006;
  for (int i = 0; i < kSides; ++i) {
    const double p = 2 * M_PI * i / kSides, q = 2 * M_PI * (i + 1) / kSides;
    const double cp = r * std::cos(p), sp = r * std::sin(p), cq = r * std::cos(q), sq = r * std::sin(q);
    add_quad(body, {{{cp, sp, -0.04}, {cq, sq, -0.04}, {cq, sq, 0.06}, {cp, sp, 0.06}}});
    add_quad(body, {{{cp, sp, 0.06}, {cq, sq, 0.06}, {0, 0, 0.064}, {0, 0, 0.064}}});
  }
  return body;
}

struct SyntheticScene {
  SceneDescription scene;
  ParticleFrame frame;
  BodyPoses poses;
  ProxySample proxy;
};

// time [s]: where the stirring stands.
inline SyntheticScene synthetic_scene(double time = 0.4, ScalarField field = ScalarField::speed,
                                      double spacing = kSpacing) {
  SyntheticScene s;
  s.scene.header.session = s.frame.session = s.poses.header.session = s.proxy.header.session = 7;
  s.scene.name = "synthetic tray";
  s.scene.spacing = spacing;
  s.scene.support_radius = 2 * spacing;
  s.scene.haptic_rate_hz = 1000;
  s.scene.bounds_min = {-0.2, -0.2, -0.1};
  s.scene.bounds_max = {0.2, 0.2, 0.3};
  const double px = 0.05 * std::cos(2 * time), py = 0.03 * std::sin(2 * time);

  BodyDescription fluid;
  fluid.name = "water";
  fluid.density = 1000;
  fluid.color = {0.20f, 0.52f, 0.86f};
  make_look(fluid, "water");
  s.frame.field = field;
  s.frame.frame = static_cast<std::uint64_t>(60 * time) + 1;
  s.frame.sim_time = time;
  for (double z = spacing / 2; z < kDepth + 0.02; z += spacing) {
    for (double y = -kHalfY + spacing / 2; y < kHalfY; y += spacing) {
      for (double x = -kHalfX + spacing / 2; x < kHalfX; x += spacing) {
        const double d = std::hypot(x - px, y - py);
        const double surface =
            kDepth + 0.012 * std::cos(60 * d - 9 * time) * std::exp(-12 * d) + 0.006 * std::sin(14 * x + 5 * time);
        if (z > surface || (std::abs(x - px) < 0.032 && std::abs(y - py) < 0.009)) continue;
        const double u = std::sin(7919 * x + 104729 * y + 1299709 * z), v = std::sin(611953 * x + 15485863 * z + 3 * y);
        for (const double c : {x + 0.12 * spacing * u, y + 0.12 * spacing * v, z + 0.1 * spacing * u * v}) {
          s.frame.positions.push_back(static_cast<float>(c));
        }
        const double speed = 0.45 * std::exp(-18 * d) + 0.02;
        const double density = 1000 + 9 * (kDepth - z) / kDepth - 3 + 4 * u * std::exp(-20 * d);
        s.frame.scalars.push_back(static_cast<float>(field == ScalarField::density ? density : speed));
      }
    }
  }
  fluid.count = static_cast<std::uint32_t>(s.frame.scalars.size());
  s.scene.bodies = {fluid, tray(), paddle()};
  s.scene.particle_count = fluid.count;
  s.scene.bodies[1].first = s.scene.bodies[2].first = fluid.count;

  s.poses.body = {2};
  s.poses.pose = {{{px, py, 0.105}, {0, 0, 0, 1}}};
  s.proxy.proxy_pose = s.poses.pose[0];
  s.proxy.sim_time = time;
  s.proxy.wrench.force = {1.9, -0.5, 0.6};
  return s;
}

}  // namespace palp::test
