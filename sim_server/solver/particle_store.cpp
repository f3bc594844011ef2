#include "sim_server/solver/particle_store.h"

#include <algorithm>
#include <cmath>

#include "sim_server/physics/equation_of_state.h"
#include "sim_server/physics/pack_frame.h"
#include "sim_server/solver/body_bounds.h"
#include "sim_server/solver/constants.h"
#include "sim_server/solver/hydrostatic_start.h"

namespace palp {
namespace {

// Returns the number of contacts that may push a body at once, by which its stiffest contact is divided to stay stable
// (rigid.h): at most about the largest face of the box around it, when it lies flat.
double contacts_at_once(const Scene& scene, const Body& body) {
  const Eigen::Array3d n = own_bounds(scene, body).sizes().array() / scene.spacing + 1;
  return std::max({20.0, n[0] * n[1], n[1] * n[2], n[2] * n[0]});
}

BodyState initial_body(const Scene& scene, const Plan& plan, std::uint32_t index) {
  const Body& body = scene.bodies[index];
  BodyState b{};
  b.kind = body.type;
  b.q = body.orientation.normalized().cast<real>();
  b.x = (body.position + body.orientation * body.center).cast<real>();
  b.v = body.velocity.cast<real>();
  b.w = body.angular_velocity.cast<real>();
  b.mass = static_cast<real>(body.mass);
  b.inertia = body.inertia.cast<real>();
  b.inverse_inertia = b.kind == BodyKind::rigid ? Mat3(body.inertia.inverse().cast<real>()) : Mat3(Mat3::Zero());
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
  b.contact_mass = real(1e30);
  if (b.kind == BodyKind::rigid) b.contact_mass = static_cast<real>(body.mass / contacts_at_once(scene, body));
  b.group = plan.group[index];
  b.shaped = (plan.fields || plan.geometry) && body.contact != nullptr;
  if (b.kind == BodyKind::elastic) {
    // each particle moves on its own, and the body's rotation is counted from its start
    b.contact_mass = static_cast<real>(body.mass / body.count);
    b.q.setIdentity();
  }
  return b;
}

}  // namespace

Eigen::Vector3d rounded(const Eigen::Vector3d& place) {
  // volatile: GCC 12 vectorises a conversion to float and back to double, and then leaves both out (-O3)
  volatile real kept[3];
  for (int a = 0; a < 3; ++a) kept[a] = static_cast<real>(place[a]);
  return {static_cast<double>(kept[0]), static_cast<double>(kept[1]), static_cast<double>(kept[2])};
}

ParticleStore::ParticleStore(const Scene& scene, const Plan& plan) {
  const std::size_t n = scene.position.size();
  xV.resize(n);
  vp.resize(n);
  mass.resize(n);
  tag.resize(n);
  id.resize(n);
  temperature.assign(scene.temperature.begin(), scene.temperature.end());
  const std::vector<double> pressure = hydrostatic_start(scene, plan);
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const bool fluid = body.type == BodyKind::fluid || plan.changes[b];
    const double rho0 = scene.config.materials[body.material].density;
    const double c = sound_speed_in(scene, plan, scene.config.materials[body.material]);
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      const double p = pressure[i];
      // the mass follows from the pressure, so that the body fills its volume in equilibrium
      mass[i] = static_cast<real>(scene.volume[i] * (fluid ? density_at(p, rho0, c) : rho0));
      xV[i] = pack(scene.position[i].cast<real>(), static_cast<real>(scene.volume[i]));
      vp[i] = pack(scene.velocity[i].cast<real>(), static_cast<real>(p));
      tag[i] = make_tag(fluid ? BodyKind::fluid : body.type, body.material, b)
                   .with_geometry(plan.geometry && !fluid && body.contact != nullptr);
      id[i] = i;
    }
    if (plan.solids) bodies.push_back(fluid ? BodyState{} : initial_body(scene, plan, b));
  }
  if (plan.heat) {
    const HeatMedium medium = make_heat_medium(scene, plan);
    enthalpy.resize(n);
    for (std::size_t i = 0; i < n; ++i) enthalpy[i] = enthalpy_of(medium.material[tag[i].material()], temperature[i]);
  }
  local.resize(plan.force_count);
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    if (plan.force_first[b] == kNone) continue;
    const Body& body = scene.bodies[b];
    // of rounded places, so that a body does not strain what is bonded to it far from the origin
    const Eigen::Vector3d center = rounded(body.position + body.orientation * body.center);
    for (std::uint32_t k = 0; k < body.count; ++k) {
      const Eigen::Vector3d r = rounded(scene.position[body.first + k]) - center;
      local[plan.force_first[b] + k] = pack((body.orientation.conjugate() * r).cast<real>(), 0);
    }
  }
}

void ParticleStore::scatter(const Medium& medium, Snapshot& out) const {
  const std::size_t n = xV.size();
  out.position.resize(3 * n);
  out.velocity.resize(3 * n);
  out.density.resize(n);
  out.pressure.resize(n);
  out.temperature.resize(temperature.size());
  out.inactive.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t to = id[i];
    for (int a = 0; a < 3; ++a) {
      out.position[3 * to + a] = static_cast<float>(xV[i].xyz()[a]);
      out.velocity[3 * to + a] = static_cast<float>(vp[i].xyz()[a]);
    }
    out.density[to] = static_cast<float>(density_of(medium, tag[i], vp[i].w));
    out.pressure[to] = static_cast<float>(acting_pressure(medium, vp[i].w));
    if (!temperature.empty()) out.temperature[to] = static_cast<float>(temperature[i]);
    out.inactive[to] = tag[i].inactive() ? 1 : 0;
  }
}

void ParticleStore::scatter_heat(const std::vector<real>& start, const HeatMedium& medium, Snapshot& out) const {
  out.heat.resize(enthalpy.size());
  out.liquid.resize(enthalpy.size());
  for (std::size_t i = 0; i < enthalpy.size(); ++i) {
    const HeatMaterial& material = medium.material[tag[i].material()];
    out.heat[id[i]] = static_cast<float>(mass[i] * (enthalpy[i] - start[id[i]]));
    out.liquid[id[i]] = material.latent > 0 ? static_cast<float>(liquid_fraction(material, enthalpy[i])) : NAN;
  }
}

CellGrid make_grid(const Scene& scene, const Plan& plan) {
  CellGrid g;
  for (int a = 0; a < 3; ++a) {
    const double length = scene.bounds_max[a] - scene.bounds_min[a];
    g.origin[a] = static_cast<real>(scene.bounds_min[a]);
    g.n[a] = plan.cells[a];
    g.cell[a] = static_cast<real>(length / plan.cells[a]);
    g.inv_cell[a] = static_cast<real>(plan.cells[a] / length);
    g.period[a] = scene.config.periodic[a] ? static_cast<real>(length) : real(0);
  }
  g.margin = static_cast<real>(plan.support);
  return g;
}

}  // namespace palp
