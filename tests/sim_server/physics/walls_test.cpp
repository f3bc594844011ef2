// The guard that keeps fluids out of solids, and their drag: against their equations in double precision, and the guard
// in a stirred tray.
#include "sim_server/physics/walls.h"

#include <vector>

#include <gtest/gtest.h>

#include "sim_server/physics/wall_sight.h"
#include "sim_server/probes/penetration.h"
#include "sim_server/solver/constants.h"
#include "sim_server/solver/contact_store.h"
#include "sim_server/solver/particle_store.h"
#include "tests/support/played_scene.h"
#include "tests/support/random.h"
#include "tests/support/scene_builder.h"
#include "tests/support/tolerance.h"

namespace palp::test::walls_test {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing = 0.05, kRadius = 0.2;
constexpr std::uint32_t kDrops = 256;  // particles that are put beside the ball

// A policy by which each solid has the same share of each particle.
struct Shared {
  real share_of_all;
  static real solid(const ParticleView&, std::uint32_t) { return 0; }
  real wall_share(Tag, real, std::uint32_t) const { return share_of_all; }
};

class WallGuard : public RandomCase {
 protected:
  WallGuard() {
    SceneConfig config = scene(kSpacing);
    config.numerics.sound_speed = 15;
    config.gravity.setZero();
    config.bodies = {body("ball", BodyKind::rigid, sphere(kRadius)),
                     body("drop", BodyKind::fluid, box({0.4, 0.4, 0.2}, {0.8, 0, 0}))};
    scene_ = sample_scene(config, 100000);
    plan_ = make_plan(scene_);
    contact_.emplace(scene_, plan_);
    store_.emplace(scene_, plan_);
    BodyState& ball = store_->bodies[0];
    ball.x = vector(0.1).cast<real>();
    ball.q = Quat(random_rotation(random_).cast<real>());
    ball.v = vector(1).cast<real>();
    ball.w = vector(3).cast<real>();
  }

  // Puts each fluid particle somewhere near the surface, from low to high spacings off, and returns what its guard and
  // the drag of a viscosity accelerate it by.
  std::vector<Vector3d> push(real share, double low = -0.5, double high = 0.5, double viscosity = 0) {
    for (std::uint32_t i = first(); i < count(); ++i) {
      const Vector3d n = vector(1).normalized();
      place_.push_back(store_->bodies[0].x.cast<double>() + (kRadius + between(low, high) * kSpacing) * n);
      speed_.push_back(vector(0.5));
      store_->xV[i] = pack(place_.back().cast<real>(), store_->xV[i].w);
      store_->vp[i] = pack(speed_.back().cast<real>(), 0);
    }
    std::vector<Packed> acceleration(count(), Packed{0, 0, 0, 0});
    const std::uint32_t of_walls = 0, place[] = {0, kNone};
    const Vec3 none(0, 0, 0);
    const Forcing forcing{none, none, none, false};
    WallForce<Shared> kernel{};
    kernel.bonds.share_of_all = share;
    kernel.forcing = &forcing;
    kernel.state.xV = store_->xV.data();
    kernel.state.vp = store_->vp.data();
    kernel.state.mass = store_->mass.data();
    kernel.state.tag = store_->tag.data();
    kernel.bodies.body = store_->bodies.data();
    std::vector<WallWrench> wrenches((count() + kWallPart - 1) / kWallPart);
    kernel.walls.by = {static_cast<std::uint32_t>(wrenches.size()), 1, place, wrenches.data()};
    kernel.walls.body = &of_walls;
    kernel.walls.shape = contact_->shape.data();
    kernel.walls.piece = contact_->piece.data();
    std::vector<Packed> slopes(count());
    std::vector<real> rates(count());
    std::vector<std::uint32_t> beside(count()), near(wrenches.size());
    std::vector<KeptBody> kept(kKeptBodies * count());
    kernel.walls.slope = slopes.data();
    kernel.walls.rate = rates.data();
    kernel.walls.beside = beside.data();
    kernel.walls.near = near.data();
    kernel.walls.kept = kept.data();
    kernel.grid = make_grid(scene_, plan_);
    kernel.medium = make_medium(scene_, plan_);
    for (Material& material : kernel.medium.material) material.viscosity = static_cast<real>(viscosity);
    kernel.count = count();
    kernel.acceleration = acceleration.data();
    dt_ = kernel.medium.dt;
    const MeasureWalls<Shared> measure{kernel.state,  kernel.bodies, kernel.walls, kernel.grid,
                                       kernel.medium, &forcing,      count(),      kernel.bonds};
    for (std::uint32_t part = 0; part < wrenches.size(); ++part) measure(part, SerialTeam{});
    for (KeptBody& solid : kept) solid.pull.setZero();  // no gravity
    for (std::uint32_t part = 0; part < wrenches.size(); ++part) {
      kernel(part, SerialTeam{});
      wrench_.force += wrenches[part].force;
      wrench_.torque += wrenches[part].torque;
    }
    std::vector<Vector3d> out;
    for (std::uint32_t i = first(); i < count(); ++i) slope_.push_back(slopes[i].xyz().cast<double>().norm());
    for (std::uint32_t i = first(); i < count(); ++i) out.push_back(acceleration[i].xyz().cast<double>());
    return out;
  }

  std::uint32_t first() const { return scene_.bodies[1].first; }
  std::uint32_t count() const { return first() + kDrops; }
  double mass(std::size_t k) const { return store_->mass[first() + k]; }

  Scene scene_;
  Plan plan_;
  std::optional<ContactStore> contact_;
  std::optional<ParticleStore> store_;
  std::vector<Vector3d> place_, speed_;
  std::vector<double> slope_;
  WallWrench wrench_{Vec3(0, 0, 0), Vec3(0, 0, 0)};
  double dt_ = 0;
};

TEST_F(WallGuard, IsASpringAndADamperAtTheEndOfTheStep) {
  ASSERT_TRUE(plan_.geometry);
  const BodyState& ball = store_->bodies[0];
  const double reach = 0.15 * kSpacing, k = 0.05 * 15 * 15 / (reach * kSpacing);
  const std::vector<Vector3d> found = push(real(0.7));
  Vector3d force(0, 0, 0), torque(0, 0, 0);
  double largest = 0;
  for (const Vector3d& a : found) largest = std::max(largest, a.norm());
  std::uint32_t pushed = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Vector3d r = place_[i] - ball.x.cast<double>(), n = r.normalized();
    const double deep = reach - (r.norm() - kRadius), b = 8 * std::sqrt(k) * deep / reach;
    const double part = (speed_[i] - ball.v.cast<double>() - ball.w.cast<double>().cross(r)).dot(n);
    const double both = 1 + mass(i) / ball.contact_mass;
    const double held = 1 + both * (b * dt_ + k * dt_ * dt_);
    const double a = deep > 0 ? std::max(0.0, (k * deep - (b + k * dt_) * part) / held) : 0;
    EXPECT_TRUE(within((found[i] - 0.7 * a * n).norm() / largest, tol::kGuard)) << i;
    pushed += a > 0;
    force -= mass(i) * found[i];
    torque -= mass(i) * r.cross(found[i]);
  }
  EXPECT_GT(pushed, kDrops / 8);  // of about a third
  EXPECT_TRUE(within((wrench_.force.cast<double>() - force).norm() / force.norm(), tol::kGuard));
  EXPECT_TRUE(within((wrench_.torque.cast<double>() - torque).norm() / (kRadius * force.norm()), tol::kGuard));
}

// Drag as if velocity grew from the surface to the particle, within a laminar layer where that is thinner.
TEST_F(WallGuard, DragsByALayer) {
  const BodyState& ball = store_->bodies[0];
  const double viscosity = 1, nu = viscosity / 500;
  const std::vector<Vector3d> found = push(1, 0.2, 1.8, viscosity);
  double largest = 0;
  for (const Vector3d& a : found) largest = std::max(largest, a.norm());
  std::uint32_t near = 0, within_layer = 0, outside_layer = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Vector3d r = place_[i] - ball.x.cast<double>(), n = r.normalized(), foot = kRadius * n;
    const double d = r.norm() - kRadius;
    const Vector3d u = speed_[i] - ball.v.cast<double>() - ball.w.cast<double>().cross(r), u_t = u - u.dot(n) * n;
    const double bend = 1 / std::hypot(r.norm(), 0.5 * kSpacing);  // of normals half a spacing from each other
    const double layer = std::max(0.25 * kSpacing, std::sqrt(nu / (bend * u_t.norm())) / 0.6);
    const double least = std::max(0.25, 0.4 * std::min(1.0, kSpacing / layer)) * kSpacing, counted = std::max(d, least);
    const Vector3d past = speed_[i] - ball.v.cast<double>() - ball.w.cast<double>().cross(foot);
    const double V = store_->xV[first() + static_cast<std::uint32_t>(i)].w;
    const Vector3d drag = -2 * viscosity * V * slope_[i] / std::min(counted, layer) * past;
    EXPECT_TRUE(within((found[i] - drag / mass(i)).norm() / largest, tol::kGuard)) << i;
    near += counted > d;
    within_layer += counted < layer;
    outside_layer += counted > layer;
  }
  EXPECT_GT(near, kDrops / 32);
  EXPECT_GT(within_layer, kDrops / 8);
  EXPECT_GT(outside_layer, kDrops / 8);
}

TEST_F(WallGuard, LeavesAloneWhatOtherForcesHold) {
  for (const Vector3d& a : push(0)) EXPECT_EQ(a.norm(), 0);
  EXPECT_EQ(wrench_.force.norm(), 0);
}

// A fluid that is driven into a corner may get beneath a wall's surface, where it must not lose the wall.
TEST_F(WallGuard, StandsBesideWhatHasGotBeneathTheSurface) {
  const std::uint32_t of_walls = 0;
  WallViews walls;
  walls.by.bodies = 1;
  walls.body = &of_walls;
  walls.shape = contact_->shape.data();
  walls.piece = contact_->piece.data();
  const CellGrid grid = make_grid(scene_, plan_);
  const Medium medium = make_medium(scene_, plan_);
  BodyState& ball = store_->bodies[0];
  ball.w = Vec3(0, 0, 0);
  const Vec3 n = vector(1).normalized().cast<real>(), pull = vector(1).cast<real>();
  const auto at = [&](double d) {
    const Passing at_rest{ball.v, pull, 0};
    return near_body(walls, grid, medium, ball, 0, ball.x + static_cast<real>(kRadius + d * kSpacing) * n, &at_rest);
  };
  const NearBody on = at(0.02);
  for (const double deep : {0.01, 0.1, 0.3, 0.49}) {
    const NearBody beneath = at(-deep);
    ASSERT_TRUE(beneath.near);
    EXPECT_NEAR(beneath.d, -deep * kSpacing, 1e-5 * kSpacing);
    EXPECT_TRUE(within(beneath.wall.share / on.wall.share - 1, tol::kBeneath)) << deep;
    EXPECT_TRUE(within((beneath.wall.slope - on.wall.slope).norm() / on.wall.slope.norm(), tol::kBeneath)) << deep;
    EXPECT_TRUE(within((beneath.wall.pull - on.wall.pull).norm() / pull.norm(), tol::kBeneath)) << deep;
    EXPECT_TRUE(within(beneath.wall.shear / on.wall.shear - 1, tol::kBeneath)) << deep;
  }
}

// At the spacing of level fast, where the ladle is two and a half spacings wide.
TEST(WallsOfATray, NoFluidEntersTheLadle) {
  PlayedScene played("tray_fluid", {"stir"});
  const PenetrationMeter meter(played.scene);
  for (int k = 1; k <= 20; ++k) {
    ASSERT_TRUE(played.play(0.1 * k));
    EXPECT_TRUE(within(meter.deepest(played.snapshot, played.simulation->output()).value() / played.scene.spacing,
                       tol::kPenetration));
  }
}

class OpenCells : public RandomCase {};

// Particles in an open cell are beside no fixed body, and a good part of a large tank is open.
TEST_F(OpenCells, AreOutOfTheReachOfFixedBodies) {
  SceneConfig config = scene(kSpacing);
  BodyConfig tank = body("tank", BodyKind::fixed, box({1.8, 1.8, 1.8}));
  tank.shapes.push_back(box({1.6, 1.6, 1.8}, {0, 0, 0.1}));
  tank.shapes.back().subtract = true;
  const Eigen::Quaterniond turned = random_rotation(random_);
  config.bodies = {tank, body("post", BodyKind::fixed, box({0.1, 0.2, 0.3})),
                   body("ball", BodyKind::rigid, sphere(0.1, {0, 0, 0.65})),
                   body("fluid", BodyKind::fluid, box({1.0, 1.0, 0.2}, {0, 0, -0.6}))};
  config.bodies[1].position = vector(0.3);
  config.bodies[1].orientation = turned;
  const Scene scene = sample_scene(config, 100000);
  const Plan plan = make_plan(scene);
  const ContactStore contact(scene, plan);
  const ParticleStore store(scene, plan);
  const CellGrid grid = make_grid(scene, plan);
  const Medium medium = make_medium(scene, plan);
  std::vector<std::uint8_t> open(grid.cells());
  WallViews walls;
  walls.by.bodies = static_cast<std::uint32_t>(contact.shaped.size());
  walls.body = contact.shaped.data();
  walls.shape = contact.shape.data();
  walls.piece = contact.piece.data();
  walls.open = open.data();
  const MarkOpenCells mark{store.bodies.data(), walls, grid, medium};
  for (std::uint32_t c = 0; c < grid.cells(); ++c) mark(c);
  int within = 0;
  for (int n = 0; n < 20000; ++n) {
    const Vec3 x = vector(1).cast<real>();
    if (open[grid.index_of(x)] == 0) continue;
    ++within;
    for (std::uint32_t k = 0; k < walls.by.bodies; ++k) {
      const BodyState& body = store.bodies[walls.body[k]];
      if (body.kind != BodyKind::fixed) continue;
      ASSERT_FALSE(near_body(walls, grid, medium, body, k, x, nullptr).near) << x.transpose();
    }
  }
  EXPECT_GT(within, 2000);
}

using SightInATray = RandomCase;

// The space that lists take for clear around a particle has no line of sight that a wall blocks.
TEST_F(SightInATray, IsOpenWhereAllIsClear) {
  SceneConfig config = scene(kSpacing);
  const double inner = 6 * kSpacing, outer = inner + 0.6 * kSpacing;
  BodyConfig tray = body("tray", BodyKind::fixed, box({outer, outer, outer}));
  tray.shapes.push_back(cut(box({inner, inner, outer}, {0, 0, 0.3 * kSpacing})));
  config.bodies = {tray, body("water", BodyKind::fluid, box({inner, inner, inner / 2}, {0, 0, -inner / 4}))};
  const Scene s = sample_scene(config, 1000000);
  const Plan plan = make_plan(s);
  const ContactStore store(s, plan);
  const std::vector<NodeGrid> grids = store.grids_at(store.node.data());
  const std::vector<std::uint32_t> bodies{0};
  BodyState state{};
  state.q = Quat(1, 0, 0, 0);
  WallSight sight{};
  sight.walls.by.bodies = 1;
  sight.walls.body = bodies.data();
  sight.walls.shape = store.shape.data();
  sight.walls.piece = store.piece.data();
  sight.walls.grid = grids.data();
  sight.body = &state;
  sight.reach = static_cast<real>(plan.support);
  sight.near = static_cast<real>(kSightNear * kSpacing);
  ASSERT_TRUE(store.shape[0].thin);
  int clear = 0, blocked = 0;
  for (int k = 0; k < 100000; ++k) {
    const Vec3 x = vector(0.6 * outer).cast<real>(), x_ij = x - Vec3(vector(0.6 * outer).cast<real>());
    if (x_ij.norm() > sight.reach) continue;
    const bool open = sight.open(x, x_ij), holds = sight.clear_around(x).holds(x_ij);
    EXPECT_TRUE(open || !holds) << x.transpose() << " to " << (x - x_ij).transpose();
    clear += holds ? 1 : 0;
    blocked += open ? 0 : 1;
  }
  EXPECT_GT(clear, 2000);
  EXPECT_GT(blocked, 100);
}

// Fluids keep as far off a surface as the guard reaches; past that they would see each other through a thin wall.
TEST(WallsOfATray, AreThinWhereFluidsReachThroughThem) {
  for (const double thick : {0.1, 1.0, 2.2, 2.6, 3.5, 5.0, 8.0}) {
    SceneConfig config = scene(kSpacing);
    const double inner = 8 * kSpacing, outer = inner + 2 * thick * kSpacing;
    BodyConfig tray = body("tray", BodyKind::fixed, box({outer, outer, outer}));
    tray.shapes.push_back(box({inner, inner, inner}));
    tray.shapes.back().subtract = true;
    config.bodies = {tray, body("fluid", BodyKind::fluid, box({0.5 * inner, 0.5 * inner, 0.5 * inner}))};
    const Scene scene = sample_scene(config, 100000);
    const Plan plan = make_plan(scene);
    const double reach = plan.support - 2 * double(kGuardReach) * kSpacing;
    EXPECT_EQ(ContactStore(scene, plan).shape[0].thin, thick * kSpacing < reach) << thick << " spacings";
  }
}

}  // namespace
}  // namespace palp::test::walls_test
