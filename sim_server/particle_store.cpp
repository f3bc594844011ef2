#include "sim_server/particle_store.h"

#include <algorithm>

#include "sim_server/pack_frame.h"

namespace palp {
namespace {

// Pressure of the fluid body above a point, as if it had always been there. Starting without it would drop the fluid by
// its compression and ring for seconds.
double resting_pressure(const Scene& scene, const Eigen::Vector3d& x, const Eigen::Vector3d& top, double density) {
  double p = 0;
  for (int a = 0; a < 3; ++a)
    if (!scene.config.periodic[a]) p += density * scene.config.gravity[a] * (x[a] - top[a]);
  return std::max(0.0, p);
}

// The corner of a fluid body that gravity points away from: where its pressure is zero.
Eigen::Vector3d surface_corner(const Scene& scene, const Body& body) {
  Eigen::Vector3d top = Eigen::Vector3d::Zero();
  for (int a = 0; a < 3; ++a) {
    const double g = scene.config.gravity[a];
    double extreme = scene.position[body.first][a];
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
      extreme = g < 0 ? std::max(extreme, scene.position[i][a]) : std::min(extreme, scene.position[i][a]);
    top[a] = extreme + (g < 0 ? 0.5 : -0.5) * scene.spacing;
  }
  return top;
}

BodyState initial_body(const Scene& scene, const Plan& plan, std::uint32_t index) {
  const Body& body = scene.bodies[index];
  BodyState b{};
  b.kind = static_cast<Kind>(body.type);
  b.q = body.orientation.normalized().cast<real>();
  b.x = (body.position + body.orientation * body.center).cast<real>();
  b.v = body.velocity.cast<real>();
  b.w = body.angular_velocity.cast<real>();
  b.mass = static_cast<real>(body.mass);
  b.inertia = body.inertia.cast<real>();
  b.inverse_inertia = b.kind == Kind::rigid ? Mat3(body.inertia.inverse().cast<real>()) : Mat3(Mat3::Zero());
  const Mat3 R = b.q.toRotationMatrix();
  b.L = R * b.inertia * R.transpose() * b.w;
  b.first = body.first;
  b.count = body.count;
  b.force_first = plan.force_first[index];
  b.proxy = -1;
  for (std::size_t p = 0; p < scene.proxies.size(); ++p)
    if (scene.proxies[p].body == index) {
      b.proxy = static_cast<std::int32_t>(p);
      b.handle = (scene.proxies[p].handle - body.center).cast<real>();
    }
  constexpr double kContactsAtOnce = 20;
  b.contact_mass = b.kind == Kind::rigid ? static_cast<real>(body.mass / kContactsAtOnce) : real(1e30);
  return b;
}

}  // namespace

ParticleStore::ParticleStore(const Scene& scene, const Plan& plan) {
  const std::size_t n = scene.position.size();
  xV.resize(n);
  vp.resize(n);
  mass.resize(n);
  tag.resize(n);
  id.resize(n);
  temperature.assign(scene.temperature.begin(), scene.temperature.end());
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const bool fluid = body.type == BodyType::fluid;
    const double rho0 = scene.config.materials[body.material].density;
    const bool pressed = fluid && body.count > 0 && scene.config.gravity_ramp == 0 && plan.method == Method::accurate;
    const Eigen::Vector3d top = pressed ? surface_corner(scene, body) : Eigen::Vector3d::Zero();
    const double c2 = plan.sound_speed * plan.sound_speed;
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      const double p = pressed ? resting_pressure(scene, scene.position[i], top, rho0) : 0;
      // the mass follows from the pressure, so that the body fills its volume in equilibrium
      mass[i] = static_cast<real>(scene.volume[i] * (fluid ? rho0 + p / c2 : rho0));
      xV[i] = pack(scene.position[i].cast<real>(), static_cast<real>(scene.volume[i]));
      vp[i] = pack(scene.velocity[i].cast<real>(), static_cast<real>(p));
      tag[i] = make_tag(static_cast<Kind>(body.type), body.material, b);
      id[i] = i;
    }
    if (plan.solids) bodies.push_back(fluid ? BodyState{} : initial_body(scene, plan, b));
  }
  local.resize(plan.force_count);
  for (std::uint32_t b : plan.reactive) {
    const Body& body = scene.bodies[b];
    const Eigen::Vector3d center = body.position + body.orientation * body.center;
    for (std::uint32_t k = 0; k < body.count; ++k)
      local[plan.force_first[b] + k] =
          pack((body.orientation.conjugate() * (scene.position[body.first + k] - center)).cast<real>(), 0);
  }
}

void ParticleStore::scatter(const Medium& medium, Snapshot& out) const {
  const std::size_t n = xV.size();
  out.position.resize(3 * n);
  out.velocity.resize(3 * n);
  out.density.resize(n);
  out.pressure.resize(n);
  out.temperature.resize(temperature.size());
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t to = id[i];
    for (int a = 0; a < 3; ++a) {
      out.position[3 * to + a] = static_cast<float>(xV[i].xyz()[a]);
      out.velocity[3 * to + a] = static_cast<float>(vp[i].xyz()[a]);
    }
    out.density[to] = static_cast<float>(density_of(medium, tag[i], vp[i].w));
    out.pressure[to] = static_cast<float>(medium.tension || vp[i].w > 0 ? vp[i].w : 0);
    if (!temperature.empty()) out.temperature[to] = static_cast<float>(temperature[i]);
  }
}

CellGrid make_grid(const Scene& scene, const Plan& plan) {
  CellGrid g;
  for (int a = 0; a < 3; ++a) {
    const double length = scene.bounds_max[a] - scene.bounds_min[a];
    g.origin[a] = static_cast<real>(scene.bounds_min[a]);
    g.n[a] = plan.cells[a];
    g.inv_cell[a] = static_cast<real>(plan.cells[a] / length);
    g.period[a] = scene.config.periodic[a] ? static_cast<real>(length) : real(0);
  }
  return g;
}

Medium make_medium(const Scene& scene, const Plan& plan) {
  Medium m{};
  for (std::size_t i = 0; i < scene.config.materials.size() && i < kMaxMaterials; ++i)
    m.material[i] = {static_cast<real>(scene.config.materials[i].density),
                     static_cast<real>(scene.config.materials[i].viscosity)};
  m.support = static_cast<real>(plan.support);
  m.spacing = static_cast<real>(scene.spacing);
  m.sound_speed = static_cast<real>(plan.sound_speed);
  m.diffusion = static_cast<real>(plan.diffusion);
  m.artificial = static_cast<real>(plan.artificial);
  m.tension = plan.tension;
  m.dt = static_cast<real>(plan.dt);
  return m;
}

}  // namespace palp
