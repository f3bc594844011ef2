// Contact of elastic bodies with rigid and fixed ones: a spring of the elastic matter itself between each particle that
// touches and the other body's surface, in place of what its half of a spacing would be squeezed. So the force does not
// depend on the sub-step. The spring is implicit (backward Euler), which no stiffness makes unstable. A particle
// touches with the face of its cell that looks at the body, in four parts, of which those that are inside bear their
// share: a ball of a few spacings is felt alike wherever it comes down between particles. The push acts where these
// parts are: on the particle's middle and, from the next sub-step on, in its stress (contact_stress()); friction on its
// middle.
//
// symbol   meaning                                                                                unit
// d, n     mean depth of the parts that are inside the body; outward normal there                 m, -
// v*       velocity against the body at the end of the sub-step, were there no contact: a tool's
//          is that of its hand (explicit); a body that falls does so by a m g / N, so that its
//          weight rests on springs of depth P / k                                                 m/s
// k, k_t   s (lambda + 2 mu) V / dx^2 times the share of parts that are inside, s = kContactLayers N/m
//          or another (contact_stiffness()); k mu / (lambda + 2 mu)
// q        dt k / (1 + dt^2 k a): the force that a unit of velocity at the end of the step takes  N s/m
// a        N / m_b: inverse of the share of the body's effective mass along n (explicit elasticity: its
//          hand's coupling included, proxy.h) that each of its N contacts has (mass splitting: Tonge, Benevolenski
//          & Voroshilov 2012); 0 for a fixed body                                                1/kg
// P        k (d - dt v*.n) q / (dt k): the push, were the particle's mass infinite                N
// push     explicit elasticity: P / (1 + dt q / m). Implicit: P - q n.y with v in place of v*, y being what the solve
//          adds to v (implicit_elastic.h), in whose matrix dt q n n^T stands. There a contact with a rigid body that
//          bears a load lasts until a sub-step has shown that it bears none, for one sub-step too long: P < 0 does not
//          tell, since y may press, and particles would touch in every other sub-step, their body bouncing on them.
//          Where P says that they part by more than kLongestGap it ends at once
//
// Friction is Coulomb's, of a spring k_t between the particle and the place where it stuck, by the same equations, cut
// off where it passes the coefficient times the push. In an implicit solve the push of the sub-step before decides
// whether a particle slips, and one that does is pushed with a given force.
#pragma once

#include "sim_server/physics/elastic.h"
#include "sim_server/physics/proxy.h"
#include "sim_server/physics/soft_contact.h"

namespace palp {

// s above: the matter between a particle and its face, half a spacing, would have 2 were it squeezed as in a wide layer
// that cannot give way sideways. Under a ball it is held more: with 4.5 balls of three to ten spacings are within 5 %
// of finite elements wherever they come down, at nu = 0.3 and 0.45 (with 5 5.5 %, with 6 6.7 %), and plates on four
// spacings sink by 1.3 % too little. What is squeezed flat is stiffer, so that no particle gets into a body.
inline constexpr real kContactLayers = real(4.5), kFlatLayers = real(32);

// Where the parts of a face lie from its middle along both its sides, the middles of quarters, and how far they are
// from the particle at most, in spacings.
inline constexpr real kFacePoint = real(0.25), kFarthestPoint = real(0.62);

// The largest stress of a push on a face, over Young's modulus: that of matter squeezed by a third.
inline constexpr real kMostPressed = real(1) / real(3);

// The gap, in spacings, across which a contact may last for a sub-step.
inline constexpr real kLongestGap = real(0.02);

// Returns dt^2 k / m. waves: what the sub-step is of the time in which a pressure wave crosses a spacing. Where that is
// long, matter is so stiff that less than its own stiffness holds it close enough, p dt^2 / (10 density spacing) under
// a pressure p, and spares the implicit solve most of its rounds. squeezed: by what share half a spacing is.
template <class S>
PALP_HD inline S contact_stiffness(S waves, S squeezed) {
  const S flat = squeezed < S(0) ? S(0) : (squeezed < S(1) ? squeezed * squeezed : S(1));
  const S layers = S(kContactLayers) + S(kFlatLayers - kContactLayers) * flat * flat;
  const S own = layers * waves * waves, enough = S(10) + S(100) / waves;
  return own < enough ? own : enough;
}

// The contact of one particle with one body in a sub-step of an implicit solve.
struct ElasticPush {
  Vec3 n;                      // normal; zero without contact
  Vec3 arm;                    // place from the body's centre [m]
  Vec3 at;                     // where the push acts, from the particle's middle [m]
  Vec3 push;                   // force for y = 0, friction included [N]
  real resists, resists_slip;  // q along n, and across it [N s/m]
  real k_slip;                 // k_t [N/m]
  bool touched;                // it touched in the last sub-step, too
  real load;                   // along n in the last sub-step, no less than 0 [N]
  real owed;                   // kinetic friction of the loads so far that has not acted yet [N]
};

PALP_HD inline ElasticPush no_elastic_push() {
  return {Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0), real(0),
          real(0),       real(0),       false,         real(0),       real(0)};
}

// Elastic particles, in the order of forces, against the bodies of the pairs that their part has.
struct ElasticTouching {
  PairPoints all;
  ElasticViews elastic;
  BodyViews bodies;
  Medium medium;
  const ProxyInput* proxy;
  real elapsed;  // AdvanceBodies::elapsed

  // A particle that may touch.
  struct Candidate {
    PairPoints::Touch t;
    Vec3 v;             // v*
    real q, q_slip;     // along n, and across it [N s/m]
    real push;          // P, positive where the particle touches [N]
    real k_slip, mass;  // k_t; of the particle
    Vec3 at;            // where the push acts, from the particle's middle [m]
  };

  // Returns true where contact stays as it is, because the body that the part is of sleeps (elastic_sleep.h).
  PALP_HD bool sleeps(const SoftPart& part) const { return elastic.tag[part.first].asleep(); }

  // The ball around the particles of a part, and how fast the fastest of them is.
  struct Ball {
    Vec3 center;
    real radius, speed;
  };

  // All of a team take part and get the answer.
  template <class Team>
  PALP_HD Ball ball_of(const SoftPart& part, Team team) const {
    const std::uint32_t middle = part.first + part.count / 2;
    const Vec3 X = elastic.rest[middle].xyz(), u = elastic.u[middle].xyz();
    real far2 = 0, fast2 = 0;
    for (std::uint32_t i = part.first + team.lane(); i < part.first + part.count; i += team.size()) {
      const Vec3 apart = nearest_image(all.grid, elastic.rest[i].xyz() - X + (elastic.u[i].xyz() - u));
      const real distance2 = apart.squaredNorm(), speed2 = elastic.v[i].xyz().squaredNorm();
      if (far2 < distance2) far2 = distance2;
      if (fast2 < speed2) fast2 = speed2;
    }
    return {X + u, Eigen::numext::sqrt(team.max(far2)), Eigen::numext::sqrt(team.max(fast2))};
  }

  // Returns true where no particle of a part can be near the body, as find() would tell one by one.
  PALP_HD bool far(const Ball& ball, const BodyState& field, const Mat3& R, const ContactBody& shape) const {
    const Vec3 x = nearest_image(all.grid, ball.center - field.x);
    const real speed = ball.speed + field.v.norm() + field.w.norm() * (x.norm() + ball.radius);
    const real margin = ball.radius + medium.spacing + real(3) * all.dt * speed;
    return outside_bounds(shape, R.transpose() * x, margin);
  }

  // Calls f(k, pair, field, R) for each pair k of a part whose body may be near, as for_each_pair does, and left(k,
  // pair) for those whose body was near in the last sub-step alone.
  template <class Team, class F, class G>
  PALP_HD void for_each_near(const SoftPart& part, Team team, F&& f, G&& left) const {
    const Ball ball = ball_of(part, team);
    for_each_pair(all, part, [&](std::uint32_t k, const ContactPair& pair, const BodyState& field, const Mat3& R) {
      if (!far(ball, field, R, all.contact.shape[pair.shape_b]))
        f(k, pair, field, R);
      else if (all.contact.by.wrench[k].near)
        left(k, pair);
    });
  }

  // Forgets the contact of a part with a body that it has left. All of a team take part.
  template <class Team>
  PALP_HD void forget(const SoftPart& part, std::uint32_t k, const ContactPair& pair, Team team) const {
    for (std::uint32_t p = team.lane(); p < part.count; p += team.size())
      all.contact.state[pair.first + p] = no_contact();
    team.sum(real(0));  // by now all have read that it was near
    if (team.leader()) all.contact.by.wrench[k] = no_wrench();
  }

  PALP_HD real mass(std::uint32_t i) const {
    return medium.material[elastic.tag[i].material()].density * elastic.rest[i].w;
  }

  // A face of the cell that a particle fills: the way to its middle, and from there the two that lead to its parts [m].
  struct Face {
    Vec3 out, across, along;
  };

  // Returns the face that looks against n most, a unit normal. Its middle is as far against n as the face of a cell
  // that has turned with the matter; were it moved with the face's own normal, to the side, too, the particle would
  // feel couples that forces in its middle do not answer.
  PALP_HD Face face_against(std::uint32_t i, const Quat& lattice, const Vec3& n) const {
    Mat3 axes = lattice.toRotationMatrix();
    int k = 0;
    real leans = 1;
    if (lattice.coeffs().isZero(0)) {  // of matter that lies anyhow one looks at what touches it
      axes.col(0) = n;
      axes.col(1) = n.unitOrthogonal();
      axes.col(2) = n.cross(axes.col(1));
    } else {
      const Vec3 looks = axes.transpose() * (elastic.rotation[i].conjugate() * n);
      for (int a = 1; a < 3; ++a)
        if (Eigen::numext::abs(looks[a]) > Eigen::numext::abs(looks[k])) k = a;
      leans = Eigen::numext::abs(looks[k]);
      axes = elastic.gradient[i] * axes;  // a face leans as matter is sheared
    }
    Face face;
    face.across = axes.col((k + 1) % 3).normalized();
    face.along = axes.col((k + 2) % 3).normalized();
    face.out = real(-0.5) * medium.spacing * leans * n;
    face.across *= kFacePoint * medium.spacing;
    face.along *= kFacePoint * medium.spacing;
    return face;
  }

  // The touch of a particle's face. depth: the greatest of the four parts'.
  struct FaceTouch : PairPoints::Touch {
    real part[4];
    Face face;
  };

  // Returns the way from the particle's middle to part q of its face [m].
  PALP_HD static Vec3 part_of(const Face& face, int q) {
    return face.out + (q % 2 == 0 ? real(-1) : real(1)) * face.across + (q / 2 == 0 ? real(-1) : real(1)) * face.along;
  }

  PALP_HD FaceTouch find(const SoftPart& part, std::uint32_t p, const ContactPair& pair, const Mat3& R,
                         ContactState& state) const {
    const std::uint32_t i = part.first + p, place = pair.first + p;
    const BodyState& field = all.body[pair.b];
    const ContactBody& shape = all.contact.shape[pair.shape_b];
    const Motion motion{elastic.rest[i].xyz(), elastic.v[i].xyz(), Vec3(0, 0, 0), false};
    const real half = real(0.5) * medium.spacing, farthest = kFarthestPoint * medium.spacing;
    FaceTouch t;
    static_cast<PairPoints::Touch&>(t) =
        all.touch(motion, motion_of(field), elastic.u[i].xyz(), farthest, false, R, shape, state.side);
    if (t.near)
      state.side = pack(R.transpose() * t.n, t.depth);
    else if (state.side.w > real(-1e29))
      state = no_contact();
    const real distance = farthest - t.depth;
    real deepest = real(-1e30);
    if (t.near) {
      t.face = face_against(i, part.lattice, t.n);
      for (int q = 0; q < 4; ++q) {
        const Vec3 to = part_of(t.face, q);
        const Distance d = solid_distance(shape, all.contact.piece, all.contact.grid, R.transpose() * (t.other + to));
        // past the middle of a thin plate it would be pushed on
        t.part[q] = (R * d.n).dot(t.n) < real(-0.5) ? -distance - to.dot(t.n) : -d.d;
        if (t.part[q] > deepest) deepest = t.part[q];
      }
    }
    ClosestApproach& kept = all.contact.near[place - all.contact.first_soft];
    const real reach = reach_of(kept, 1, half, t.near ? half - deepest : half);
    t.depth = deepest;
    if (t.near && reach < half) {
      t.depth -= half - reach;
      for (real& depth : t.part) depth -= half - reach;
    }
    return t;
  }

  // Notes that nothing presses on the particles of a part.
  template <class Team>
  PALP_HD void release(const SoftPart& part, Team team) const {
    for (std::uint32_t p = team.lane(); p < part.count; p += team.size())
      elastic.pressed[part.first + p] = Mat3::Zero();
  }

  // Notes a push [N] on particle i, which acts `at` from its middle [m], or nearer to it: no farther than the face of a
  // cell that is squeezed, and not where it would squeeze matter flat, as what hits a body at the speed of its waves
  // would throw particles off. Matter that yields takes no more on its strain than its yield stress: what is pressed
  // through it would be thrown back. Returns where it acts.
  PALP_HD Vec3 press(std::uint32_t i, const Vec3& push, const Vec3& at) const {
    const Material& m = medium.material[elastic.tag[i].material()];
    const Vec3 acts = within_cell(elastic.gradient[i], at);
    const real volume = elastic.rest[i].w, size = push.norm() * acts.norm();
    const real young = m.shear * (real(3) * m.lame + real(2) * m.shear) / (m.lame + m.shear);
    const real bears = kMostPressed * young * volume, most = m.yield > real(0) ? min(bears, m.yield * volume) : bears;
    const Vec3 limited = (size > most ? most / size : real(1)) * acts;
    elastic.pressed[i] -= push * (limited / volume).transpose();
    return limited;
  }

  // Returns N of a body. All of a team take part and get the answer, which no order of adding up changes.
  template <class Team>
  PALP_HD real contacts_of(std::uint32_t body, Team team) const {
    if (!all.contact.elastic_on_rigid || all.body[body].kind != BodyKind::rigid) return real(0);
    const PairWrenches& by = all.contact.by;
    real sum = 0;
    for (std::uint32_t p = by.of_body[body] + team.lane(); p < by.of_body[body + 1]; p += team.size())
      sum += by.wrench[by.part[p] / 2].contacts;
    return team.sum(sum);
  }

  // How a body would move, and yields, at a touch.
  struct Give {
    Vec3 gain;     // what its velocity gains in the sub-step, were there no contact [m/s]
    real inverse;  // 1 / m_b [1/kg]
  };

  PALP_HD Give give_of(const BodyState& field, const Mat3& R, const PairPoints::Touch& t) const {
    if (field.kind != BodyKind::rigid) return {Vec3(0, 0, 0), real(0)};
    if (field.proxy < 0) {
      const real inverse = inverse_mass_along(field, R, t);
      const Vec3 fall = surroundings(all.grid, *all.forcing, field.x, all.dt).pull;
      return {(all.dt * inverse * field.mass) * fall, inverse};
    }
    // beside an implicit solve a tool counts with its mass alone: with its coupling a hand of 100 m/s created energy
    if (all.contact.elastic_push != nullptr) return {Vec3(0, 0, 0), inverse_mass_along(field, R, t)};
    const ProxyInput& hand = proxy[field.proxy];
    if (!hand.engaged) return {Vec3(0, 0, 0), real(0)};  // its tool is held
    // where the coupling weighs more than the tool, the tool's own mass and velocity say little of where it will be
    const ProxyStep s = begin_proxy(field, Vec3(0, 0, 0), Vec3(0, 0, 0), device_after(hand, elapsed), hand.gains,
                                    all.forcing->gravity + all.forcing->body_force, no_resistance(), all.dt);
    Vec3 v, w;
    s.mass.solve(t.n, t.other.cross(t.n), v, w);
    const real inverse = t.n.dot(v + w.cross(t.other));
    s.mass.solve(s.p, s.l, v, w);
    return {v - field.v + (w - field.w).cross(t.other), inverse};
  }

  // Returns true for a contact of an implicit solve that bore a load in the last sub-step, with a body that could
  // bounce.
  PALP_HD static bool lasts(const ElasticPush& last, const BodyState& field) {
    return field.kind == BodyKind::rigid && field.proxy < 0 && last.load > real(0);
  }

  // Returns v*; an implicit solve adds the particle's own forces as y.
  PALP_HD Vec3 velocity(std::uint32_t i, const PairPoints::Touch& t, const Give& give) const {
    if (all.contact.elastic_push != nullptr) return t.v - give.gain;
    const Vec3 x = elastic.rest[i].xyz() + elastic.u[i].xyz();
    const Vec3 pull = surroundings(all.grid, *all.forcing, x, all.dt).pull;
    return t.v + all.dt * (bodies.force[i].xyz() / mass(i) + pull) - give.gain;
  }

  // Returns what the contact of particle i would be with the touch t.
  PALP_HD Candidate candidate(std::uint32_t i, const FaceTouch& t, const BodyState& field, const Mat3& R,
                              real contacts) const {
    const Material& m = medium.material[elastic.tag[i].material()];
    const Give give = give_of(field, R, t);
    const real dt = all.dt, a = contacts * give.inverse;
    Candidate c;
    c.mass = mass(i);
    c.t = t;
    c.v = velocity(i, t, give);
    const real leaves = dt * c.v.dot(t.n);
    real depth = 0, parts = 0, sum = 0;
    c.at = Vec3(0, 0, 0);
    for (int q = 0; q < 4; ++q) {
      sum += t.part[q];
      if (!(t.part[q] > leaves)) continue;
      depth += t.part[q];
      c.at += part_of(t.face, q);
      parts += real(1);
    }
    if (!(parts > real(0))) {  // what may last for a sub-step, does so as a whole
      depth = sum;
      c.at = real(4) * t.face.out;
      parts = real(4);
    }
    depth /= parts;
    c.at /= parts;
    const real wave = Eigen::numext::sqrt((m.lame + real(2) * m.shear) / m.density);
    const real squeezed = real(2) * depth / medium.spacing;
    const real k = real(0.25) * parts * contact_stiffness(dt * wave / medium.spacing, squeezed) * c.mass / (dt * dt);
    c.k_slip = k * m.shear / (m.lame + real(2) * m.shear);
    c.q = dt * k / (real(1) + dt * dt * k * a);
    c.q_slip = dt * c.k_slip / (real(1) + dt * dt * c.k_slip * a);
    c.push = c.q * (depth / dt - c.v.dot(t.n));
    return c;
  }

  // Returns the force across n of a particle that sticks, for y = 0 [N]. anchor: ContactState::anchor, world axes.
  PALP_HD Vec3 sticking(const Candidate& c, const Vec3& anchor) const {
    const Vec3 across = c.v - c.v.dot(c.t.n) * c.t.n, s = anchor - anchor.dot(c.t.n) * c.t.n;
    return -c.q_slip * (s / all.dt + across);
  }
};

}  // namespace palp
