#include "tests/support/equations.h"

#include <cmath>

#include "tests/support/kernels.h"
#include "tests/support/restated_shift.h"

namespace palp::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

const Body& body_of(const Restated& w, std::size_t i) { return w.scene->bodies[w.scene->body[i]]; }
bool is_fluid(const Restated& w, std::size_t i) { return body_of(w, i).type == BodyKind::fluid; }
bool is_fixed(const Restated& w, std::size_t i) { return body_of(w, i).type == BodyKind::fixed; }
const MaterialConfig& material_of(const Restated& w, std::size_t i) {
  return w.scene->config.materials[body_of(w, i).material];
}
double density0(const Restated& w, std::size_t i) { return material_of(w, i).density; }
// c^2 of a tenth of the stiffness of the heaviest fluid at least
double sound(const Restated& w, std::size_t i) {
  double heaviest = 0;
  for (const Body& body : w.scene->bodies)
    if (body.type == BodyKind::fluid) heaviest = std::max(heaviest, w.scene->config.materials[body.material].density);
  return w.plan.sound_speed * std::max(1.0, std::sqrt(heaviest / (10 * density0(w, i))));
}
double impedance(const Restated& w, std::size_t i) { return density0(w, i) * sound(w, i); }
double acting(const Restated& w, double p) { return w.plan.tension ? p : std::max(0.0, p); }

Vector3d nearest_image(const Restated& w, Vector3d d) {
  for (int a = 0; a < 3; ++a) {
    const double period = w.scene->bounds_max[a] - w.scene->bounds_min[a];
    if (w.scene->config.periodic[a]) d[a] -= period * std::round(d[a] / period);
  }
  return d;
}

template <class F>
void for_pairs(const Restated& w, std::size_t i, F&& f) {
  for (std::size_t j = 0; j < w.x.size(); ++j) {
    const Vector3d d = nearest_image(w, w.x[i] - w.x[j]);
    if (j != i && d.norm() < w.plan.support) f(j, d);
  }
}

// Gravity that pressure can balance.
Vector3d level_gravity(const Restated& w) {
  Vector3d g = w.scene->config.gravity;
  for (int a = 0; a < 3; ++a)
    if (w.scene->config.periodic[a]) g[a] = 0;
  return g;
}

Matrix3d cross(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Eigen::Quaterniond turned(const Eigen::Quaterniond& q, const Vector3d& rotation) {
  if (rotation.norm() == 0) return q;
  return (Eigen::Quaterniond(Eigen::AngleAxisd(rotation.norm(), rotation.normalized())) * q).normalized();
}

// d rho/dt = - rho div v + delta h c sum_j V_j psi_ij . gradW + rho k e (C/C0 - 1) (1 - (2 H |grad C|)^2)+,
// psi_ij = 2 (rho_j - rho_i - hydrostatic) x_ji / r^2, C = sum_j V_j W_ij with j = i, k = 0.1,
// e = sum_j V_j |v_ij.gradW|, not where C is 20 % from C0; diffusion not past the mean; V = m / rho(acting pressure).
// Where rho > rho0 then, by backward Euler: d rho/dt = (rho0 - rho) c / dx (1 - (C - V_i W_ii) / (0.05 C0))+
void continuity(Restated& w) {
  const double h = 0.5 * w.plan.support, lattice = lattice_cover(w.plan.support / w.scene->spacing);
  std::vector<double> rho_new(w.x.size());
  for (std::size_t i = 0; i < w.x.size(); ++i) {
    if (!is_fluid(w, i)) continue;
    const double c = sound(w, i), c2 = c * c, rho0 = density0(w, i), rho_i = rho0 + w.p[i] / c2;
    double divergence = 0, diffusion = 0, diffusing = 0, strain = 0;
    const double own = w.V[i] * fluid_kernel(0, w.plan.support, w.scene->spacing);
    double cover = own;
    Vector3d slope = Vector3d::Zero();
    for_pairs(w, i, [&](std::size_t j, const Vector3d& x_ij) {
      const Vector3d gradient = fluid_gradient(x_ij, w.plan.support, w.scene->spacing);
      cover += w.V[j] * fluid_kernel(x_ij.norm(), w.plan.support, w.scene->spacing);
      slope += w.V[j] * gradient;
      const Vector3d v_j = is_fixed(w, j) ? Vector3d::Zero() : w.v[j];
      strain += std::abs(w.V[j] * (w.v[i] - v_j).dot(gradient));
      // towards the velocity that an interface would have, twice: it is half way
      const Vector3d v_meet = (impedance(w, i) * w.v[i] + impedance(w, j) * v_j) / (impedance(w, i) + impedance(w, j));
      divergence += w.V[j] * (is_fluid(w, j) ? Vector3d(2 * (v_meet - w.v[i])) : Vector3d(v_j - w.v[i])).dot(gradient);
      if (!is_fluid(w, j) || body_of(w, j).material != body_of(w, i).material) return;
      // density does not diffuse between particles that are at rest against each other
      const double moves = (w.v[i] - w.v[j]).dot(x_ij) / (0.0003 * c * w.scene->spacing);
      const double weight = std::min(1.0, moves * moves) * w.V[j] * 2 * (-x_ij).dot(gradient) / x_ij.squaredNorm();
      diffusion += weight * (rho0 + w.p[j] / c2 - rho_i - rho0 * level_gravity(w).dot(-x_ij) / c2);
      diffusing += weight;
    });
    const double drift = cover / lattice - 1, edge = 2 * w.plan.support * slope.norm();
    const double tie = std::abs(drift) > 0.2 ? 0 : 0.1 * strain * drift * std::max(0.0, 1 - edge * edge);
    w.slope[i] = -slope;
    w.strain[i] = strain;
    const double spread = std::min(w.plan.diffusion * h * c, 1 / (w.plan.dt * diffusing));
    rho_new[i] = rho_i + w.plan.dt * (rho_i * (tie - divergence) + spread * diffusion);
    const double alone = std::max(0.0, 1 - (cover - own) / (0.05 * lattice));
    if (rho_new[i] > rho0) rho_new[i] = rho0 + (rho_new[i] - rho0) / (1 + alone * w.plan.dt * c / w.scene->spacing);
  }
  for (std::size_t i = 0; i < w.x.size(); ++i) {
    if (!is_fluid(w, i)) continue;
    w.p[i] = sound(w, i) * sound(w, i) * (rho_new[i] - density0(w, i));
    w.V[i] = w.m[i] / std::max(rho_new[i], w.plan.tension ? 0 : density0(w, i));
  }
}

// Adami, Hu & Adams 2012, eqs. 23 and 27 without the wall's acceleration.
void extrapolate_to_walls(Restated& w) {
  const Vector3d g = level_gravity(w);
  for (std::size_t i = 0; i < w.x.size(); ++i) {
    if (is_fluid(w, i)) continue;
    double p = 0, sum = 0;
    Vector3d v = Vector3d::Zero();
    for_pairs(w, i, [&](std::size_t j, const Vector3d& x_ij) {
      if (!is_fluid(w, j)) return;
      const double W = fluid_kernel(x_ij.norm(), w.plan.support, w.scene->spacing);
      p += (acting(w, w.p[j]) + density_of(w, j) * g.dot(x_ij)) * W;
      v += w.v[j] * W;
      sum += W;
    });
    w.wall_pressure[i] = sum > 0 ? acting(w, p / sum) : 0;
    w.wall_velocity[i] = sum > 0 ? Vector3d(2 * w.v[i] - v / sum) : w.v[i];
  }
}

// Force of j, fluid or solid, on fluid particle i.
Vector3d force_on_fluid(const Restated& w, std::size_t i, std::size_t j, const Vector3d& x_ij) {
  const Vector3d gradient = fluid_gradient(x_ij, w.plan.support, w.scene->spacing);
  const double h = 0.5 * w.plan.support, r2 = x_ij.squaredNorm();
  const bool wall = !is_fluid(w, j);
  double p_j = wall ? w.wall_pressure[j] : acting(w, w.p[j]);
  // a solid's particles within 0.8 spacings push with the fluid's stiffness
  const double inside = 1 - x_ij.norm() / (0.8 * w.scene->spacing);
  if (wall && inside > 0) p_j += density0(w, i) * sound(w, i) * sound(w, i) * inside;
  const double mu_i = material_of(w, i).viscosity, mu_j = wall ? mu_i : material_of(w, j).viscosity;
  const double Z_i = impedance(w, i), Z_j = wall ? Z_i : impedance(w, j), Z = 2 * Z_i * Z_j / (Z_i + Z_j);
  const Vector3d v_ij = w.v[i] - w.v[j];
  const Vector3d shear = w.v[i] - (wall ? w.wall_velocity[j] : w.v[j]);
  const double mu = mu_i + mu_j > 0 ? 2 * mu_i * mu_j / (mu_i + mu_j) : 0;
  // pressure; Morris, Fox & Zhu; Monaghan & Gingold, alpha c h rho v.x / (r^2 + 0.01 h^2)
  const double p_meet = (Z_j * acting(w, w.p[i]) + Z_i * p_j) / (Z_i + Z_j);
  Vector3d f = -w.V[i] * w.V[j] * 2 * p_meet * gradient;
  f += w.V[i] * w.V[j] * 2 * mu * x_ij.dot(gradient) / r2 * shear;
  f += w.V[i] * w.V[j] * w.plan.artificial * Z * h * v_ij.dot(x_ij) / (r2 + 0.01 * h * h) * gradient;
  return f;
}

// The share of a body's mass that a contact reckons with, the solver's choice: a part for each particle of the largest
// face of its box, twenty at least.
double contact_mass(const Restated& w, const Body& body) {
  if (body.type != BodyKind::rigid) return 1e30;
  Eigen::Array3d low = Eigen::Array3d::Constant(1e30), high = -low;
  for (const Vector3d& x : w.body[&body - w.scene->bodies.data()].local) {
    low = low.min(x.array());
    high = high.max(x.array());
  }
  const Eigen::Array3d n = 1 + (high - low) / w.scene->spacing;
  return body.mass / std::max(20.0, n.prod() / n.minCoeff());
}

// Spring and damper between particles of different solids that are closer than a spacing.
Vector3d contact_force(const Restated& w, std::size_t i, std::size_t j, const Vector3d& x_ij) {
  const double overlap = w.scene->spacing - x_ij.norm(), dt = w.plan.dt;
  if (overlap <= 0) return Vector3d::Zero();
  const double m = std::min(contact_mass(w, body_of(w, i)), contact_mass(w, body_of(w, j)));
  const Vector3d n = x_ij.normalized();
  const double push = 0.4 * m / (dt * dt) * overlap - 0.15 * m / dt * (w.v[i] - w.v[j]).dot(n);
  return std::max(0.0, push) * n;
}

void accurate_forces(Restated& w) {
  continuity(w);
  extrapolate_to_walls(w);
  for (std::size_t i = 0; i < w.x.size(); ++i) {
    w.force[i].setZero();
    for_pairs(w, i, [&](std::size_t j, const Vector3d& x_ij) {
      if (is_fluid(w, i))
        w.force[i] += force_on_fluid(w, i, j, x_ij);
      else if (is_fluid(w, j))
        w.force[i] -= force_on_fluid(w, j, i, -x_ij);
      else if (w.scene->body[i] != w.scene->body[j])
        w.force[i] += contact_force(w, i, j, x_ij);
    });
  }
}

// Paper Eq. 1 to 3 with Mueller's kernels, of which density and pressure have the same.
void paper_forces(Restated& w) {
  const double H = w.plan.support, c2 = w.plan.sound_speed * w.plan.sound_speed;
  for (std::size_t i = 0; i < w.x.size(); ++i) {
    double sum = poly6(0, H);
    for_pairs(w, i, [&](std::size_t, const Vector3d& x_ij) { sum += poly6(x_ij.norm(), H); });
    w.p[i] = c2 * (w.m[i] * sum - density0(w, i));
    w.V[i] = 1 / sum;
  }
  for (std::size_t i = 0; i < w.x.size(); ++i) {
    w.force[i].setZero();
    for_pairs(w, i, [&](std::size_t j, const Vector3d& x_ij) {
      if (!is_fluid(w, i) && w.scene->body[i] == w.scene->body[j]) return;
      const double P = (acting(w, w.p[i]) + acting(w, w.p[j])) / 2;
      const double mu = (material_of(w, i).viscosity + material_of(w, j).viscosity) / 2;
      w.force[i] -= w.V[i] * w.V[j] * P * poly6_gradient(x_ij, H);
      w.force[i] += mu * w.V[i] * w.V[j] * viscosity_laplacian(x_ij.norm(), H) * (w.v[j] - w.v[i]);
    });
  }
}

void advance_free(RestatedBody& b, const Body& body, const Vector3d& gravity, double dt) {
  const auto inverse = [&](const Eigen::Quaterniond& q) {
    return Matrix3d(q.toRotationMatrix() * body.inertia.inverse() * q.toRotationMatrix().transpose());
  };
  b.v += dt * (b.force / body.mass + gravity);
  b.x += dt * b.v;
  b.L += dt * b.torque;
  b.w = inverse(turned(b.q, 0.5 * dt * (inverse(b.q) * b.L))) * b.L;
  b.q = turned(b.q, dt * b.w);
}

// Backward Euler of spring and damper as one 6 x 6 system: with J the velocity of the handle from that of the body,
// M (u' - u) = dt (W + J^T (K (e - dt J u') + B (u_d - J u')))
void advance_coupled(RestatedBody& b, const Body& body, const DeviceInput& in, const Vector3d& gravity, double elapsed,
                     double dt) {
  const Matrix3d R = b.q.toRotationMatrix(), I = R * body.inertia * R.transpose();
  const Vector3d r = R * b.handle;
  Matrix6d M = Matrix6d::Zero(), J = Matrix6d::Identity(), K = Matrix6d::Zero(), B = Matrix6d::Zero();
  M.topLeftCorner<3, 3>() = body.mass * Matrix3d::Identity();
  M.bottomRightCorner<3, 3>() = I;
  J.topRightCorner<3, 3>() = -cross(r);
  K.diagonal() << Vector3d::Constant(in.gains.stiffness), Vector3d::Constant(in.gains.angular_stiffness);
  B.diagonal() << Vector3d::Constant(in.gains.damping), Vector3d::Constant(in.gains.angular_damping);
  const Eigen::AngleAxisd turn(turned(in.state.orientation, elapsed * in.state.angular) * b.q.conjugate());
  Vector6d u, e, u_d, W;
  u << b.v, b.w;
  e << in.state.position + elapsed * in.state.linear - (b.x + r), turn.angle() * turn.axis();
  u_d << in.state.linear, in.state.angular;
  W << b.force + body.mass * gravity, b.torque - b.w.cross(I * b.w);
  const Matrix6d A = M + dt * J.transpose() * (dt * K + B) * J;
  const Vector6d rhs = M * u + dt * (W + J.transpose() * (K * e + B * u_d));
  const Vector6d next = A.fullPivLu().solve(rhs);
  const Vector6d coupling = K * (e - dt * J * next) + B * (u_d - J * next), moved = J * next;
  b.coupling = coupling.head<3>();
  b.work[0] -= dt * coupling.head<3>().dot(moved.head<3>());
  b.work[1] -= dt * coupling.tail<3>().dot(moved.tail<3>());
  b.work_size[0] += dt * ((K * e).head<3>().norm() + (B * u_d).head<3>().norm()) * moved.head<3>().norm();
  b.work_size[1] += dt * ((K * e).tail<3>().norm() + (B * u_d).tail<3>().norm()) * moved.tail<3>().norm();
  b.v = next.head<3>();
  b.w = next.tail<3>();
  b.x += dt * b.v;
  b.work_rounding += coupling.head<3>().norm() * b.x.norm() * (sizeof(real) == sizeof(float) ? 0x1p-24 : 0x1p-53);
  b.q = turned(b.q, dt * b.w);
}

void advance_bodies(Restated& w, const StepInput& input, double elapsed) {
  const Vector3d gravity = w.scene->config.gravity + w.scene->config.body_force;
  for (std::size_t k = 0; k < w.body.size(); ++k) {
    const Body& body = w.scene->bodies[k];
    if (body.type == BodyKind::fluid) continue;
    RestatedBody& b = w.body[k];
    b.force.setZero();
    b.torque.setZero();
    b.force_size = b.torque_size = 0;
    for (std::uint32_t i = 0; i < body.count; ++i) {
      const Vector3d& f = w.force[body.first + i];
      const Vector3d moment = (b.q * b.local[i]).cross(f);
      b.force += f;
      b.torque += moment;
      b.force_size += f.norm();
      b.torque_size += moment.norm();
    }
    if (body.type != BodyKind::rigid) continue;
    if (b.proxy < 0)
      advance_free(b, body, gravity, w.plan.dt);
    else if (input[b.proxy].engaged)
      advance_coupled(b, body, input[b.proxy], gravity, elapsed, w.plan.dt);
    else
      b.v = b.w = b.L = Vector3d::Zero();
  }
}

void move(Restated& w) {
  for (std::size_t i = 0; i < w.x.size(); ++i) {
    const Body& body = body_of(w, i);
    if (body.type == BodyKind::fluid) {
      w.v[i] += w.plan.dt * (w.force[i] / w.m[i] + w.scene->config.gravity + w.scene->config.body_force);
      w.x[i] += w.plan.dt * w.v[i];
      if (w.plan.shifts) w.x[i] += shift_of(w, i);
    } else if (body.type == BodyKind::rigid) {
      const RestatedBody& b = w.body[w.scene->body[i]];
      const Vector3d r = b.q * b.local[i - body.first];
      w.v[i] = b.v + b.w.cross(r);
      w.x[i] = b.x + r;
    }
    for (int a = 0; a < 3; ++a) {
      const double low = w.scene->bounds_min[a], period = w.scene->bounds_max[a] - low;
      if (w.scene->config.periodic[a]) w.x[i][a] -= period * std::floor((w.x[i][a] - low) / period);
    }
  }
}

// rho0 g d below the highest face of the body, none with a gravity that grows in. In the scenes of the tests a second
// fluid, where there is one, lies on the first along z.
double resting_pressure(const Restated& w, const Body& body, std::size_t i) {
  if (w.scene->config.gravity_ramp > 0 || w.scene->config.method == Method::paper) return 0;
  const auto highest = [&](const Body& b, const Vector3d& g) {  // the largest -g.x of the body's faces
    double most = -1e30;
    for (std::uint32_t k = b.first; k < b.first + b.count; ++k)
      most = std::max(most, -g.dot(w.x[k]) + 0.5 * g.lpNorm<1>() * w.scene->spacing);
    return most;
  };
  const Vector3d g = level_gravity(w);
  double p = 0;
  for (int a = 0; a < 3; ++a) {
    const Vector3d along = g[a] * Vector3d::Unit(a);
    p += density0(w, i) * (highest(body, along) + along.dot(w.x[i]));
  }
  if (&body != &w.scene->bodies[0] || w.scene->bodies.size() < 2 || w.scene->bodies[1].type != BodyKind::fluid)
    return p;
  const Body& above = w.scene->bodies[1];
  const Vector3d down(0, 0, g.z());
  return p + density0(w, above.first) * (highest(above, down) + highest(above, -down));
}

}  // namespace

Restated restate(const Scene& scene) {
  Restated w;
  w.scene = &scene;
  w.plan = make_plan(scene);
  w.x = scene.position;
  w.v = scene.velocity;
  w.V = scene.volume;
  const std::size_t n = w.x.size();
  w.p.assign(n, 0);
  w.m.resize(n);
  w.wall_pressure.assign(n, 0);
  w.wall_velocity.assign(n, Vector3d::Zero());
  w.force = w.slope = w.smooth = w.wall_velocity;
  w.strain.assign(n, 0);
  w.layer.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    if (is_fluid(w, i)) w.p[i] = resting_pressure(w, body_of(w, i), i);
    w.m[i] = w.V[i] * density_of(w, i);
  }
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    const Body& body = scene.bodies[k];
    RestatedBody b;
    b.q = body.orientation;
    b.x = body.position + body.orientation * body.center;
    b.v = body.velocity;
    b.w = body.angular_velocity;
    b.L = b.q * (body.inertia * (b.q.conjugate() * b.w));
    for (std::uint32_t i = 0; i < body.count; ++i)
      b.local.push_back(b.q.conjugate() * (scene.position[body.first + i] - b.x));
    for (std::size_t p = 0; p < scene.proxies.size(); ++p) {
      if (scene.proxies[p].body != k) continue;
      b.proxy = static_cast<int>(p);
      b.handle = scene.proxies[p].handle - body.center;
    }
    w.body.push_back(b);
  }
  return w;
}

void sub_step(Restated& w, const StepInput& input, double elapsed) {
  if (w.plan.method == Method::paper)
    paper_forces(w);
  else
    accurate_forces(w);
  advance_bodies(w, input, elapsed);
  move(w);
  if (w.plan.shifts && (++w.steps <= 4 || w.steps % w.plan.layer_interval == 0))
    look_around(w, lattice_cover(w.plan.support / w.scene->spacing), [](auto&&... of) { for_pairs(of...); });
}

double places_apart(const Restated& w, const Snapshot& s) {
  const auto x = Eigen::Map<const Eigen::Matrix3Xf>(s.position.data(), 3, w.x.size()).cast<double>();
  double worst = 0;
  for (std::size_t i = 0; i < w.x.size(); ++i) worst = std::max(worst, nearest_image(w, x.col(i) - w.x[i]).norm());
  return worst / w.scene->spacing;
}
double density_of(const Restated& w, std::size_t i) { return density0(w, i) + w.p[i] / std::pow(sound(w, i), 2); }
RigidState handle_of(const Restated& w, std::size_t proxy) {
  const RestatedBody& b = w.body[w.scene->proxies[proxy].body];
  const Vector3d r = b.q * b.handle;
  return {b.x + r, b.q, b.v + b.w.cross(r), b.w};
}

}  // namespace palp::test
