#include "sim_server/solver/constants.h"

#include <algorithm>
#include <cmath>

#include "sim_server/solver/elastic_stencil.h"
#include "sim_server/solver/lattice.h"

namespace palp {
namespace {

// The largest kappa of explicit contact.
constexpr double kMaxStiffness = 0.4;
// The kappa of implicit contact. Stability does not limit it, but with more of it a bounce depends on the moment of
// arrival; at this value by 4 % of the speed.
constexpr double kMaxImplicitStiffness = 1;
// The largest kappa + 2 gamma. The stability limit is 4, and the sum counts twice between two movable bodies, and where
// there is one on either side.
constexpr double kShareOfLimit = 1.6;

// Returns kappa and gamma for a share of critical damping.
BounceCoefficients damped(double zeta, bool implicit) {
  if (implicit) return {kMaxImplicitStiffness, 2 * zeta * std::sqrt(kMaxImplicitStiffness)};
  const double root = std::sqrt(4 * zeta * zeta + kShareOfLimit) - 2 * zeta;
  const double kappa = std::min(kMaxStiffness, root * root);
  return {kappa, 2 * zeta * std::sqrt(kappa)};
}

// Returns the speed after a bounce over the speed before, of a ball that begins `start` of its step away from contact;
// units are those of mass, step and speed.
double bounce(const BounceCoefficients& n, bool implicit, double start) {
  double depth = -start, v = 1;
  for (int step = 0; step < 1000 && !(v < 0 && depth < -1); ++step) {
    const double half = 0.5 * std::abs(v);
    const double mean = mean_depth(depth, half), share = share_inside(depth, half);
    if (v <= 0 && depth < -half) break;
    const double moved = implicit ? 1 + share * (n.stiffness + n.damping) : 1;
    v -= std::max(0.0, n.stiffness * mean + n.damping * share * v) / moved;
    depth += v;
  }
  return -v;
}

// The speed ratios over the moments within a step at which a ball may arrive.
struct Bounces {
  double mean = 0, max = 0;
};

Bounces bounces(const BounceCoefficients& n, bool implicit) {
  constexpr int kStarts = 32;
  Bounces all;
  for (int s = 0; s < kStarts; ++s) {
    const double one = bounce(n, implicit, 1 + (s + 0.5) / kStarts);
    all.mean += one / kStarts;
    all.max = std::max(all.max, one);
  }
  return all;
}

// Returns sum |dF/dx| of a particle in the corner of a lattice, the largest that a lattice has [1/m].
double corner_reach(double dx, double H) {
  const auto kernel = WendlandC2Of<double>::with_support(H);
  const auto each = [&](auto&& f) {
    const int reach = static_cast<int>(H / dx) + 1;
    for (int x = 0; x <= reach; ++x)
      for (int y = 0; y <= reach; ++y)
        for (int z = 0; z <= reach; ++z) {
          const Eigen::Vector3d X = dx * Eigen::Vector3d(x, y, z);
          const double r = X.norm();
          if (r > 0 && r < 0.999 * H) f(X, kernel.F(r));
        }
  };
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  each([&](const Eigen::Vector3d& X, double w) { moment += w * X * X.transpose(); });
  const Eigen::Matrix3d L = moment.inverse();
  Eigen::Vector3d all = Eigen::Vector3d::Zero();
  double sum = 0;
  each([&](const Eigen::Vector3d& X, double w) {
    const Eigen::Vector3d slope = w * L * X;
    all += slope;
    sum += slope.norm();
  });
  return sum + all.norm();
}

// Returns true for the material of a body whose bonds form and end (physics/state_change.h).
bool bonds_change(const Scene& scene, const Plan& plan, const MaterialConfig& material) {
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (plan.changes[b] && &scene.config.materials[scene.bodies[b].material] == &material) return true;
  return false;
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
  const bool balanced = takes_balanced_bonds(from) && !bonds_change(scene, plan, from);
  m.hourglass = (balanced ? kBalancedHourglassShare : kHourglassShare) * static_cast<real>(*from.young_modulus);
  return m;
}

}  // namespace

double shear_modulus(const MaterialConfig& m) { return *m.young_modulus / (2 * (1 + m.poisson_ratio)); }

double lame_lambda(const MaterialConfig& m) {
  return *m.young_modulus * m.poisson_ratio / ((1 + m.poisson_ratio) * (1 - 2 * m.poisson_ratio));
}

double pressure_wave_speed(const MaterialConfig& m) {
  return std::sqrt((lame_lambda(m) + 2 * shear_modulus(m)) / m.density);
}

double sound_speed_in(const Scene& scene, const Plan& plan, const MaterialConfig& material) {
  if (plan.method == Method::paper) return plan.sound_speed;
  double heaviest = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (scene.bodies[b].type == BodyKind::fluid || plan.changes[b])
      heaviest = std::max(heaviest, scene.config.materials[scene.bodies[b].material].density);
  return plan.sound_speed * std::max(1.0, std::sqrt(0.1 * heaviest / material.density));
}

double elastic_damping(const Scene& scene, const Plan& plan, const MaterialConfig& m) {
  if (plan.method != Method::paper) return m.damping;
  return m.damping + 0.01 * std::sqrt(*m.young_modulus * m.density) * scene.spacing;
}

bool is_uniform(const Scene& scene, const Plan& plan) {
  return plan.one_fluid && !plan.change && std::all_of(scene.bodies.begin(), scene.bodies.end(), [](const Body& b) {
           return b.type == BodyKind::fluid || b.count == 0;
         });
}

Medium make_medium(const Scene& scene, const Plan& plan) {
  Medium m{};
  for (std::size_t i = 0; i < scene.config.materials.size() && i < kMaxMaterials; ++i)
    m.material[i] = to_material(scene, plan, scene.config.materials[i]);
  m.kernel = FluidKernel::with_support(static_cast<real>(plan.support), static_cast<real>(scene.spacing));
  m.spacing = static_cast<real>(scene.spacing);
  m.sound_speed = static_cast<real>(plan.sound_speed);
  m.diffusion = static_cast<real>(plan.diffusion);
  m.artificial = static_cast<real>(plan.artificial);
  m.shift = static_cast<real>(plan.shift);
  m.cover = static_cast<real>(lattice_sums(plan.support / scene.spacing).W);
  m.tension = plan.tension;
  m.uniform = is_uniform(scene, plan);
  m.dt = static_cast<real>(plan.dt);
  return m;
}

CohesionMedium make_cohesion_medium(const Scene& scene, const Plan& plan) {
  CohesionMedium m{};
  const double N = cohesion_norm(plan.support);
  for (std::size_t i = 0; i < scene.config.materials.size() && i < kMaxMaterials; ++i) {
    m.tension[i] = static_cast<real>(scene.config.materials[i].surface_tension / N);
    m.adhesion[i] = static_cast<real>(scene.config.materials[i].adhesion / N);
  }
  return m;
}

HeatMedium make_heat_medium(const Scene& scene, const Plan& plan) {
  HeatMedium m{};
  // where a material does not melt its enthalpy counts from the middle of the scene, which loses the fewest digits
  double mean = 0;
  for (const double T : scene.temperature) mean += T / static_cast<double>(scene.temperature.size());
  for (std::size_t i = 0; i < scene.config.materials.size() && i < kMaxMaterials; ++i) {
    const MaterialConfig& from = scene.config.materials[i];
    // the capacity of a material that no body is made of is not checked
    m.material[i] = {
        static_cast<real>(from.conductivity), static_cast<real>(from.heat_capacity > 0 ? from.heat_capacity : 1),
        static_cast<real>(from.melting_temperature.value_or(mean)),
        static_cast<real>(from.melting_temperature ? from.latent_heat : 0), static_cast<real>(from.density)};
  }
  m.dt = static_cast<real>(plan.heat_dt);
  m.loss = static_cast<real>(scene.config.heat.loss_to_air);
  m.air_temperature = static_cast<real>(scene.config.heat.air_temperature);
  const double H = plan.support / scene.spacing;
  const LatticeSums within = lattice_sums(H);
  double depth = 0;
  for (int row = 0; row < 5; ++row)
    depth += std::max(0.0, 1 - lattice_sums(H, row).W / within.W - static_cast<double>(kCoverNoise));
  m.moment = static_cast<real>(within.moment);
  m.cover = static_cast<real>(within.W);
  m.depth = static_cast<real>(depth * scene.spacing);
  return m;
}

ChangeMedium make_change_medium(const Scene& scene, const Plan& plan) {
  ChangeMedium m{};
  const HeatMedium heat = make_heat_medium(scene, plan);
  for (std::size_t i = 0; i < scene.config.materials.size() && i < kMaxMaterials; ++i) {
    const MaterialConfig& from = scene.config.materials[i];
    m.heat[i] = heat.material[i];
    m.cooking[i] = static_cast<real>(from.cooking_temperature.value_or(0));
    m.rigid_below[i] = static_cast<real>(from.rigid_below.value_or(0));
    m.rigid_when_set[i] = from.rigid_when_set;
    m.cooking_rate[i] = static_cast<real>(from.cooking_temperature ? 1 / from.cooking_time : 0);
  }
  m.dt = static_cast<real>(plan.heat_interval / scene.config.rate_hz);
  m.support = static_cast<real>(plan.change_support);
  m.slack = static_cast<real>(plan.skin);
  m.max_reach = static_cast<real>(corner_reach(scene.spacing, plan.change_support) * 1.001);
  return m;
}

BounceCoefficients bounce_coefficients(double restitution, bool implicit) {
  const auto is_more = [&](double zeta) {
    const Bounces found = bounces(damped(zeta, implicit), implicit);
    return found.mean > restitution || found.max > 0.999;  // between the starts it may be more
  };
  double low = 0, high = implicit ? 4 : 1.2;
  if (is_more(high)) return damped(high, implicit);
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = (low + high) / 2;
    (is_more(middle) ? low : high) = middle;
  }
  return damped(high, implicit);
}

ContactLaw contact_law(const MaterialConfig& a, const MaterialConfig& b, bool implicit) {
  const double restitution = std::min(a.restitution, b.restitution);
  const BounceCoefficients bounce = bounce_coefficients(restitution, implicit);
  ContactLaw law{};
  law.friction = static_cast<real>(std::sqrt(a.friction * b.friction));
  law.kinetic = static_cast<real>(std::sqrt(a.kinetic_friction * b.kinetic_friction));
  law.stiffness = static_cast<real>(bounce.stiffness);
  law.damping = static_cast<real>(bounce.damping);
  const double most = 0.5 * (kShareOfLimit - bounce.stiffness);
  law.resting = static_cast<real>(implicit ? bounce.damping : std::max(bounce.damping, most));
  // 2/7: with as much as along the normal a block on a slope, whose load swings from edge to edge, swung for ever at a
  // restitution of 0.6; critically damped, within kShareOfLimit
  law.tangential = real(2) / real(7) * static_cast<real>(std::min(kMaxStiffness, bounce.stiffness));
  law.drag = real(2) * std::sqrt(law.tangential);
  law.implicit = implicit;
  return law;
}

ContactLaw soft_contact_law(const MaterialConfig& soft, const MaterialConfig& other) {
  ContactLaw law = contact_law(soft, other, false);
  // its own elasticity makes it bounce; the layer that touches is only damped as springs are (rigid.h)
  law.stiffness = real(0.4);
  law.damping = law.resting = real(0.15);
  law.tangential = real(2) / real(7) * law.stiffness;
  law.drag = real(0.6) * std::sqrt(law.tangential);
  return law;
}

}  // namespace palp
