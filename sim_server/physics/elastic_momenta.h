// The rigid motion of implicit elastic bodies that are bonded to nothing: the start of their solve, and the momenta at
// its end.
#pragma once

#include "sim_server/physics/implicit_elastic.h"

namespace palp {

// Starts the solve of each body that is bonded to nothing with the rigid motion that what acts from outside gives it,
// contact included. Rigid motions are eigenvectors of the preconditioned problem, of eigenvalue 1, since elasticity
// does not resist them. So what is left of r has no part in them in any round, and rounds that would find them are
// saved. One team a body.
struct BeginRigid {
  ElasticViews elastic;
  ImplicitViews solve;
  BodyViews bodies;

  PALP_HD Mat3 held(std::uint32_t i) const {
    const Mat3 mass = (real(1) / solve.residual[i].w) * Mat3::Identity();
    return solve.hold != nullptr ? Mat3(mass + solve.hold[i]) : mass;
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t k, Team team) const {
    const BodyState& b = bodies.body[solve.free_body[k]];
    if (elastic.tag[b.force_first].asleep()) return;
    const std::uint32_t end = b.force_first + b.count;
    const auto place = [&](std::uint32_t i) { return Vec3(elastic.rest[i].xyz() - b.x + elastic.u[i].xyz()); };
    Vec3 x(0, 0, 0);
    real mass = 0;
    for (std::uint32_t i = b.force_first + team.lane(); i < end; i += team.size()) {
      x += place(i) / solve.residual[i].w;
      mass += real(1) / solve.residual[i].w;
    }
    mass = team.sum(mass);
    x = team.sum(x) / mass;
    real size2 = 0;
    for (std::uint32_t i = b.force_first + team.lane(); i < end; i += team.size())
      size2 += (place(i) - x).squaredNorm();
    size2 = team.sum(size2) / real(b.count);
    // (A C; C^T D) (v; w) = (p; l), lengths in units of the body's size
    const real unit = size2 > real(0) ? real(1) / Eigen::numext::sqrt(size2) : real(0);
    Mat3 A = Mat3::Zero(), C = Mat3::Zero(), D = Mat3::Zero();
    Vec3 p(0, 0, 0), l(0, 0, 0);
    for (std::uint32_t i = b.force_first + team.lane(); i < end; i += team.size()) {
      const Mat3 m = held(i), R = cross_matrix(Vec3(unit * (place(i) - x)));
      const Vec3 r = solve.residual[i].xyz();
      A += m / mass;
      C -= m / mass * R;
      D -= R * (m / mass) * R;
      p += r / mass;
      l += R * (r / mass);
    }
    A = team_sum(team, A), C = team_sum(team, C), D = team_sum(team, D);
    p = team.sum(p), l = team.sum(l);
    const Mat3 light = A.inverse();
    // a body on a line does not turn about it
    const Mat3 turning = D - C.transpose() * light * C + real(1e-5) * (D.trace() + real(1)) * Mat3::Identity();
    const Vec3 w = turning.inverse() * (l - C.transpose() * (light * p)), v = light * (p - C * w);
    for (std::uint32_t i = b.force_first + team.lane(); i < end; i += team.size()) {
      const Vec3 y = v + w.cross(Vec3(unit * (place(i) - x)));
      const Packed r = solve.residual[i];
      solve.change[i] = pack(y, 0);
      solve.residual[i] = pack(r.xyz() - held(i) * y, r.w);
    }
  }
};

// Gives y the momentum and angular momentum of all that acts from outside on bodies that are bonded to nothing.
// Elasticity may give them neither, but rounding adds some of both, and the parts of the slope that K leaves out turn
// the body. One team a body.
struct ConserveMomenta {
  ElasticViews elastic;
  ImplicitViews solve;
  BodyViews bodies;
  real dt;

  template <class Team>
  PALP_HD void operator()(std::uint32_t k, Team team) const {
    const BodyState& b = bodies.body[solve.free_body[k]];
    if (elastic.tag[b.force_first].asleep()) return;
    const std::uint32_t end = b.force_first + b.count;
    // the outer impulse over the density [m^3 m/s]
    const auto pushed = [&](std::uint32_t i) {
      return Vec3(solve.outer[i].xyz() * (elastic.rest[i].w * solve.residual[i].w));
    };
    Vec3 x(0, 0, 0), y(0, 0, 0);
    real volume = 0;
    for (std::uint32_t i = b.force_first + team.lane(); i < end; i += team.size()) {
      const Packed X = elastic.rest[i];
      x += X.w * (X.xyz() - b.x + elastic.u[i].xyz());
      y += X.w * solve.change[i].xyz() - pushed(i);
      volume += X.w;
    }
    volume = team.sum(volume);
    x = team.sum(x) / volume, y = team.sum(y) / volume;
    Mat3 spread = Mat3::Zero();
    Vec3 turn(0, 0, 0);
    for (std::uint32_t i = b.force_first + team.lane(); i < end; i += team.size()) {
      const Packed X = elastic.rest[i];
      const Vec3 r = X.xyz() - b.x + elastic.u[i].xyz() - x;
      spread += (X.w * r) * r.transpose();
      turn += r.cross(X.w * (solve.change[i].xyz() - y) - pushed(i));
      if (elastic.pressed != nullptr)
        turn -= (dt * X.w * solve.residual[i].w) * contact_couple(elastic.pressed[i], X.w);
    }
    spread = team_sum(team, spread);
    turn = team.sum(turn);
    // a body on a line does not turn about it
    const real size = spread.trace();
    const Mat3 inertia = (real(1) + real(1e-5)) * Mat3::Identity() - spread / size;
    const Vec3 w = size > real(0) ? Vec3(inertia.inverse() * (turn / size)) : Vec3(0, 0, 0);
    for (std::uint32_t i = b.force_first + team.lane(); i < end; i += team.size()) {
      const Vec3 r = elastic.rest[i].xyz() - b.x + elastic.u[i].xyz() - x;
      solve.change[i] = pack(solve.change[i].xyz() - y - w.cross(r), 0);
    }
  }
};

}  // namespace palp
