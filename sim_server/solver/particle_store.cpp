#include "sim_server/solver/particle_store.h"

#include <algorithm>
#include <cmath>

#include "sim_server/physics/pack_frame.h"
#include "sim_server/solver/elastic_plan.h"
#include "sim_server/solver/heat_plan.h"

namespace palp {
namespace {

// The box around a body's particle centres.
struct Extent {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e30), high = -low;
};

// Whether body b has a particle next to the one of body a that is farthest against gravity along the axis.
bool covers(const Scene& scene, const Body& b, const Body& a, int axis, double gravity) {
  Eigen::Vector3d top = scene.position[a.first];
  for (std::uint32_t i = a.first; i < a.first + a.count; ++i)
    if (gravity * scene.position[i][axis] < gravity * top[axis]) top = scene.position[i];
  for (std::uint32_t i = b.first; i < b.first + b.count; ++i)
    if ((scene.position[i] - top).norm() < 1.5 * scene.spacing && gravity * (scene.position[i] - top)[axis] < 0)
      return true;
  return false;
}

Extent extent_of(const Scene& scene, const Body& body, const Eigen::Quaterniond& axes) {
  Extent e;
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
    const Eigen::Vector3d x = axes.conjugate() * scene.position[i];
    e.low = e.low.cwiseMin(x);
    e.high = e.high.cwiseMax(x);
  }
  return e;
}

// What other fluid bodies do to one along one axis.
struct Load {
  double pressure = 0;     // at the face that gravity points away from [Pa]
  double carrying = 1e30;  // density of the fluid that it is immersed in and that is below it, too [kg/m^3]
};

// The weight of the fluid bodies that lie on the whole of it, or that it is immersed in.
Load load_on(const Scene& scene, const std::vector<Extent>& extent, std::size_t body, int axis) {
  const double dx = scene.spacing, g = scene.config.gravity[axis];
  const Extent& e = extent[body];
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (b == body || scene.bodies[b].type != BodyKind::fluid || scene.bodies[b].count == 0) continue;
    const double below = e.low[axis] - extent[b].low[axis], above = extent[b].high[axis] - e.high[axis];
    const double distance = g < 0 ? extent[b].low[axis] - e.high[axis] : e.low[axis] - extent[b].high[axis];
    bool around = true;
    for (int a = 0; a < 3; ++a)
      around = around && (a == axis || (extent[b].low[a] < e.low[a] + dx && extent[b].high[a] > e.high[a] - dx));
    const bool on_top = around && distance > 0.5 * dx && distance < 1.5 * dx;
    const double rises = g < 0 ? above : below;
    const bool immersed =
        around && distance < 0 && rises > 0.5 * dx && covers(scene, scene.bodies[b], scene.bodies[body], axis, g);
    if (!on_top && !immersed) continue;
    const double density = scene.config.materials[scene.bodies[b].material].density;
    const double height = immersed ? rises : extent[b].high[axis] - extent[b].low[axis] + dx;
    const bool carries = immersed && (g < 0 ? below : above) > 0.5 * dx;
    return {density * std::abs(g) * height + load_on(scene, extent, b, axis).pressure, carries ? density : 1e30};
  }
  return {};
}

// Pressures of a fluid body as if it had always been there, under its own weight and that of the fluids on it. Starting
// without would drop the fluid by its compression and ring for seconds. A drop in a lighter fluid falls: its weight is
// on nothing.
std::vector<double> resting_pressure(const Scene& scene, const std::vector<Extent>& extent, std::size_t index) {
  const Body& body = scene.bodies[index];
  const double density = scene.config.materials[body.material].density;
  std::vector<double> p(body.count, 0.0);
  for (int a = 0; a < 3; ++a) {
    const double g = scene.config.gravity[a];
    if (scene.config.periodic[a] || g == 0) continue;
    const double top = g < 0 ? extent[index].high[a] + 0.5 * scene.spacing : extent[index].low[a] - 0.5 * scene.spacing;
    const Load load = load_on(scene, extent, index, a);
    const double carried = std::min(density, load.carrying);
    for (std::uint32_t k = 0; k < body.count; ++k)
      p[k] += load.pressure + carried * g * (scene.position[body.first + k][a] - top);
  }
  return p;
}

// How many contacts may push a body at once: what its stiffest contact is divided by to stay stable (rigid.h). At most
// about the largest face of the box around it, when it lies flat.
double contacts_at_once(const Scene& scene, const Body& body) {
  const Extent e = extent_of(scene, body, body.orientation);
  const Eigen::Array3d n = (e.high - e.low).array() / scene.spacing + 1;
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
  b.shaped = plan.fields && body.contact != nullptr;
  if (b.kind == BodyKind::elastic) {
    // each particle moves on its own, and the body's rotation is counted from its start
    b.contact_mass = static_cast<real>(body.mass / body.count);
    b.q.setIdentity();
  }
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
  std::vector<Extent> extent;
  for (const Body& body : scene.bodies) extent.push_back(extent_of(scene, body, Eigen::Quaterniond::Identity()));
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const bool fluid = body.type == BodyKind::fluid || plan.changes[b];
    const double rho0 = scene.config.materials[body.material].density;
    const bool pressed = body.type == BodyKind::fluid && body.count > 0 && scene.config.gravity_ramp == 0 &&
                         plan.method == Method::accurate;
    const std::vector<double> resting = pressed ? resting_pressure(scene, extent, b) : std::vector<double>();
    const double c2 = std::pow(sound_speed_in(scene, plan, scene.config.materials[body.material]), 2);
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      const double p = pressed ? resting[i - body.first] : 0;
      // the mass follows from the pressure, so that the body fills its volume in equilibrium
      mass[i] = static_cast<real>(scene.volume[i] * (fluid ? rho0 + p / c2 : rho0));
      xV[i] = pack(scene.position[i].cast<real>(), static_cast<real>(scene.volume[i]));
      vp[i] = pack(scene.velocity[i].cast<real>(), static_cast<real>(p));
      tag[i] = make_tag(fluid ? BodyKind::fluid : body.type, body.material, b);
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
  out.gone.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t to = id[i];
    for (int a = 0; a < 3; ++a) {
      out.position[3 * to + a] = static_cast<float>(xV[i].xyz()[a]);
      out.velocity[3 * to + a] = static_cast<float>(vp[i].xyz()[a]);
    }
    out.density[to] = static_cast<float>(density_of(medium, tag[i], vp[i].w));
    out.pressure[to] = static_cast<float>(acting_pressure(medium, vp[i].w));
    if (!temperature.empty()) out.temperature[to] = static_cast<float>(temperature[i]);
    out.gone[to] = tag[i].gone() ? 1 : 0;
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

Material to_material(const Scene& scene, const Plan& plan, const MaterialConfig& from) {
  Material m{};
  m.sound_speed = static_cast<real>(sound_speed_in(scene, plan, from));
  m.density = static_cast<real>(from.density);
  m.viscosity = static_cast<real>(from.viscosity);
  if (!from.young_modulus) return m;
  m.shear = static_cast<real>(shear_modulus(from));
  m.lame = static_cast<real>(lame_lambda(from));
  m.damping = static_cast<real>(elastic_damping(scene, plan, from));
  m.yield = static_cast<real>(from.yield_stress.value_or(0));
  m.hardening = static_cast<real>(from.hardening);
  m.tear = static_cast<real>(from.tear_strain.value_or(0));
  return m;
}

CohesionMedium make_cohesion(const Scene& scene, const Plan& plan) {
  CohesionMedium m{};
  const double N = cohesion_norm(plan.support);
  for (std::size_t i = 0; i < scene.config.materials.size() && i < kMaxMaterials; ++i) {
    m.tension[i] = static_cast<real>(scene.config.materials[i].surface_tension / N);
    m.adhesion[i] = static_cast<real>(scene.config.materials[i].adhesion / N);
  }
  return m;
}

Medium make_medium(const Scene& scene, const Plan& plan) {
  Medium m{};
  for (std::size_t i = 0; i < scene.config.materials.size() && i < kMaxMaterials; ++i)
    m.material[i] = to_material(scene, plan, scene.config.materials[i]);
  m.support = static_cast<real>(plan.support);
  m.spacing = static_cast<real>(scene.spacing);
  m.sound_speed = static_cast<real>(plan.sound_speed);
  m.diffusion = static_cast<real>(plan.diffusion);
  m.artificial = static_cast<real>(plan.artificial);
  m.tension = plan.tension;
  m.uniform = plan.one_fluid && !plan.solids && !plan.change;
  m.dt = static_cast<real>(plan.dt);
  return m;
}

}  // namespace palp
