// The arrays of each module on a back end B: allocated once, filled again at every reset, read for a snapshot. A module
// that the plan does not name has none.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "sim_server/solver/constants.h"
#include "sim_server/solver/contact_store.h"
#include "sim_server/solver/elastic_plan.h"
#include "sim_server/solver/elastic_store.h"
#include "sim_server/solver/heat_plan.h"
#include "sim_server/solver/simulation.h"
#include "sim_server/solver/sleep_plan.h"
#include "sim_server/solver/state_change_plan.h"
#include "sim_server/solver/step.h"

namespace palp {

// Allocates an array that never changes and fills it; returns nullptr when it is empty.
template <class B, class T>
T* allocate_copy(B& back_end, const std::string& name, const std::vector<T>& from) {
  if (from.empty()) return nullptr;
  T* to = back_end.template allocate<T>(name, from.size());
  back_end.upload(to, from);
  return to;
}

template <class B>
void allocate_elastic(B& back_end, const Scene& scene, const Plan& plan, StepViews& v) {
  const ElasticStore store(scene, plan);
  const std::size_t n = plan.elastic_count;
  ElasticViews& e = v.elastic;
  e.count = plan.elastic_count;
  e.rest = allocate_copy(back_end, "elastic rest", store.rest);
  e.tag = allocate_copy(back_end, "elastic tag", store.tag);
  e.first = allocate_copy(back_end, "elastic first", store.first);
  e.neighbor = allocate_copy(back_end, "elastic neighbors", store.neighbor);
  e.correction = allocate_copy(back_end, "elastic correction", store.correction);
  e.projection = allocate_copy(back_end, "elastic projection", store.projection);
  e.u = back_end.template allocate<Packed>("elastic displacement", n);
  e.v = back_end.template allocate<Packed>("elastic velocity", n);
  e.rotation = back_end.template allocate<Quat>("elastic rotation", n);
  e.gradient = back_end.template allocate<Mat3>("elastic gradient", n);
  e.stress = back_end.template allocate<Mat3>("elastic stress", n);
  e.stored = back_end.template allocate<real>("elastic stored energy", n);
  if (plan.plastic) {
    e.plastic = back_end.template allocate<Mat3>("elastic plastic part", n);
    e.hardened = back_end.template allocate<real>("elastic plastic strain", n);
  }
  if (plan.tears) {
    e.torn = back_end.template allocate<std::uint8_t>("elastic torn bonds", store.neighbor.size());
    e.stretch = back_end.template allocate<Packed>("elastic stretch", n);
    e.integrity = back_end.template allocate<real>("elastic integrity", n);
  }
  v.list.elastic = allocate_copy(back_end, "elastic bodies", plan.elastic_bodies);
}

// Allocates the arrays of an implicit solve, beside the above.
template <class B>
void allocate_implicit(B& back_end, const Scene& scene, const Plan& plan, StepViews& v) {
  ImplicitViews& s = v.implicit;
  const std::size_t neighbors = ElasticStore(scene, plan).neighbor.size();
  const std::size_t n = plan.elastic_count;
  s.rounds = static_cast<std::uint32_t>(plan.elastic_rounds);
  s.parts = static_cast<std::uint32_t>(std::clamp<std::size_t>(n / 256, 1, 128));
  s.pair = back_end.template allocate<Packed>("implicit pairs", neighbors);
  s.predicted = back_end.template allocate<Packed>("implicit predicted place", n);
  s.rotation = back_end.template allocate<Quat>("implicit rotation", n);
  s.residual = back_end.template allocate<Packed>("implicit residual", n);
  s.scaled = back_end.template allocate<Packed>("implicit scaled residual", n);
  s.image = back_end.template allocate<Packed>("implicit image", n);
  s.direction = back_end.template allocate<Packed>("implicit direction", n);
  s.advance = back_end.template allocate<Packed>("implicit advance", n);
  s.change = back_end.template allocate<Packed>("implicit change", n);
  s.outer = back_end.template allocate<Packed>("implicit outer impulse", n);
  s.sums = back_end.template allocate<Packed>("implicit sums", s.parts);
  s.round = back_end.template allocate<SolveRound>("implicit rounds", s.rounds);
  s.unsolved = back_end.template allocate<real>("implicit unsolved", 1);
  const std::vector<std::uint32_t> free = free_elastic_bodies(scene, plan);
  s.free_bodies = static_cast<std::uint32_t>(free.size());
  if (v.contact.elastic_parts > 0) s.hold = back_end.template allocate<Mat3>("implicit hold", n);
  s.free_body = allocate_copy(back_end, "implicit free bodies", free);
  double mass = 0;
  for (const std::uint32_t b : plan.elastic_bodies)
    mass += static_cast<double>(v.medium.material[scene.bodies[b].material].density) * scene.bodies[b].volume;
  s.min_work = static_cast<real>(mass * kMinSpeed2);
  const WendlandC2 kernel = WendlandC2::with_support(static_cast<real>(plan.elastic_support));
  back_end.for_each("implicit pairs", v.elastic.count, ListPairs{v.elastic, s, v.grid, kernel});
}

// Allocates what says what sleeps, and the boxes of bodies that may wake it.
template <class B>
void allocate_sleep(B& back_end, const Scene& scene, const Plan& plan, StepViews& v) {
  SleepViews& s = v.sleep;
  const NumericsConfig& numerics = scene.config.numerics;
  s.interval = static_cast<real>(plan.sleep_interval / scene.config.rate_hz);
  s.patience = static_cast<std::uint32_t>(std::ceil(kSleepAfter / s.interval));
  s.box = allocate_copy(back_end, "sleep boxes", sleep_boxes(scene, plan));
  s.speed = static_cast<real>(numerics.sleep_speed.value_or(0));
  s.region = static_cast<real>(numerics.region_of_interest.value_or(0));
  if (plan.neighbors) {
    const real reach = static_cast<real>(plan.support + plan.skin);
    s.cells = std::max(1, static_cast<int>(std::ceil(real(0.999) * reach / v.grid.cell.minCoeff())));
    for (int a = 0; a < 3; ++a) s.n[a] = (v.grid.n[a] + s.cells - 1) / s.cells;
    s.quiet = back_end.template allocate<std::uint32_t>("quiet blocks", s.blocks());
    s.lists_due = back_end.lists_due();
    back_end.let_sleep(v.sorted.tag);
  }
  if (!plan.elastic) return;
  const SleepUnits units = sleep_units(scene, ElasticStore(scene, plan));
  v.elastic_sleep.units = static_cast<std::uint32_t>(units.unit.size());
  v.elastic_sleep.unit = allocate_copy(back_end, "sleep units", units.unit);
  v.elastic_sleep.member = allocate_copy(back_end, "sleep members", units.member);
}

// Lets nothing be thought at rest, so that what sleeps wakes when it is judged next; what is inert sleeps for good.
template <class B>
void reset_sleep(B& back_end, const Scene& scene, const Plan& plan, const StepViews& v) {
  if (plan.neighbors) back_end.upload(v.sleep.quiet, std::vector<std::uint32_t>(v.sleep.blocks(), 0));
  if (v.elastic_sleep.units == 0) return;
  ElasticStore store(scene, plan);
  back_end.upload(v.elastic_sleep.unit, sleep_units(scene, store).unit);
  ElasticViews rest;
  rest.tag = store.tag.data();
  rest.first = store.first.data();
  for (std::uint32_t i = 0; i < plan.elastic_count; ++i)
    if (rest.inert(i)) store.tag[i] = store.tag[i].as_asleep(true);
  back_end.upload(v.elastic.tag, store.tag);
}

template <class B>
void reset_elastic(B& back_end, const Scene& scene, const Plan& plan, const ElasticViews& e) {
  const ElasticStore store(scene, plan);
  const std::size_t n = plan.elastic_count;
  back_end.upload(e.u, store.u);
  back_end.upload(e.v, store.v);
  back_end.upload(e.rotation, store.rotation);
  back_end.upload(e.gradient, std::vector<Mat3>(n, Mat3::Identity()));
  if (plan.plastic) {
    back_end.upload(e.plastic, std::vector<Mat3>(n, Mat3::Identity()));
    back_end.upload(e.hardened, std::vector<real>(n, real(0)));
  }
  if (e.pressed != nullptr) back_end.upload(e.pressed, std::vector<Mat3>(n, Mat3::Zero()));
  if (plan.tears) {
    back_end.upload(e.correction, store.correction);
    back_end.upload(e.projection, store.projection);
    back_end.upload(e.torn, std::vector<std::uint8_t>(store.neighbor.size(), 0));
    back_end.upload(e.stretch, std::vector<Packed>(n, Packed{0, 0, 0, 0}));
    back_end.upload(e.integrity, std::vector<real>(n, real(1)));
  }
}

template <class B>
void reset_implicit(B& back_end, const Plan& plan, const ImplicitViews& s) {
  back_end.upload(s.rotation, std::vector<Quat>(plan.elastic_count, Quat::Identity()));
  back_end.upload(s.unsolved, std::vector<real>(1, real(0)));
}

template <class B>
void snapshot_elastic(B& back_end, const Scene& scene, const Plan& plan, const StepViews& v, Snapshot& out) {
  const WendlandC2 kernel = WendlandC2::with_support(static_cast<real>(plan.elastic_support));
  back_end.for_each("stored energy", v.elastic.count, MeasureStored{v.elastic, v.grid, kernel, v.medium});
  std::vector<real> stored(plan.elastic_count);
  back_end.download(stored, v.elastic.stored);
  out.stored.assign(scene.position.size(), 0);
  for (const std::uint32_t b : plan.elastic_bodies)
    for (std::uint32_t k = 0; k < scene.bodies[b].count; ++k)
      out.stored[scene.bodies[b].first + k] = static_cast<float>(stored[plan.force_first[b] + k]);
}

// The distance fields of bodies in the back end's memory.
struct ContactFields {
  const ContactBody* shape = nullptr;
  const Piece* piece = nullptr;
  const NodeGrid* grid = nullptr;
};

template <class B>
ContactFields allocate_fields(B& back_end, const ContactStore& store) {
  ContactFields f;
  f.shape = allocate_copy(back_end, "distance shapes", store.shape);
  f.piece = allocate_copy(back_end, "distance pieces", store.piece);
  const Packed* node = allocate_copy(back_end, "distance nodes", store.node);
  f.grid = allocate_copy(back_end, "distance grids", store.grids_at(node));
  return f;
}

template <class B>
void allocate_walls(B& back_end, const Scene& scene, const Plan& plan, const CellGrid& grid, const ContactStore& store,
                    const ContactFields& fields, FluidViews& fluid) {
  WallViews& g = fluid.walls;
  std::vector<std::uint32_t> place(scene.bodies.size(), kNone);
  for (std::uint32_t k = 0; k < store.shaped.size(); ++k) place[store.shaped[k]] = k;
  g.by.bodies = static_cast<std::uint32_t>(store.shaped.size());
  g.part = scene.position.size() < kManyForWalls ? kWallPart : kLargeWallPart;
  g.by.parts = static_cast<std::uint32_t>((scene.position.size() + g.part - 1) / g.part);
  g.by.place = allocate_copy(back_end, "wall places", place);
  g.by.wrench = back_end.template allocate<WallWrench>("wall wrenches", std::size_t(g.by.parts) * g.by.bodies);
  g.body = allocate_copy(back_end, "wall bodies", store.shaped);
  g.shape = fields.shape;
  g.piece = fields.piece;
  g.grid = fields.grid;
  g.thin = std::any_of(store.shape.begin(), store.shape.end(), [](const ContactBody& b) { return b.thin; });
  g.nodes =
      std::any_of(store.piece.begin(), store.piece.end(), [](const Piece& p) { return p.type == PieceType::grid; });
  g.slope = back_end.template allocate<Packed>("wall slopes", scene.position.size());
  g.rate = back_end.template allocate<real>("wall rates", scene.position.size());
  g.beside = back_end.template allocate<std::uint32_t>("wall counts", scene.position.size());
  g.near = back_end.template allocate<std::uint32_t>("wall parts", g.by.parts);
  g.kept = back_end.template allocate<KeptBody>("walls beside particles", kKeptBodies * scene.position.size());
  if (!grid.periodic(0) && !grid.periodic(1) && !grid.periodic(2))
    g.open = back_end.template allocate<std::uint8_t>("open cells", grid.cells());
  if (plan.viscous_stages == 0) return;
  ViscosityViews& v = fluid.viscosity;
  v.wall = g.body;
  v.drag_wrench =
      back_end.template allocate<WallWrench>("viscous wall wrenches", std::size_t(g.by.parts) * g.by.bodies);
  v.drag_moments =
      back_end.template allocate<DragMoments>("viscous wall moments", std::size_t(g.by.parts) * g.by.bodies);
  v.turning = back_end.template allocate<TurningDrag>("viscous wall turning", std::size_t(g.by.parts) * g.by.bodies);
}

// The sizes of the arrays in which contacts keep their memory from step to step.
struct ContactCounts {
  std::size_t states = 0, elastic_states = 0, soft_states = 0, pairs = 0;
};

template <class B>
ContactCounts allocate_contact(B& back_end, const ContactStore& store, const ContactFields& fields, const Plan& plan,
                               ContactViews& c) {
  c.by.rigid_pairs = store.rigid_pairs;
  c.elastic_parts = static_cast<std::uint32_t>(store.elastic_part.size());
  c.single_pass = store.single_pass;
  c.elastic_on_rigid = store.elastic_on_rigid;
  c.pair = allocate_copy(back_end, "contact pairs", store.pair);
  c.shape = fields.shape;
  c.piece = fields.piece;
  c.grid = fields.grid;
  c.point = allocate_copy(back_end, "contact points", store.point);
  c.round = allocate_copy(back_end, "contact rounds", store.round);
  c.elastic_part = allocate_copy(back_end, "contact elastic parts", store.elastic_part);
  c.frozen_parts = static_cast<std::uint32_t>(store.frozen_part.size());
  c.frozen_part = allocate_copy(back_end, "contact frozen parts", store.frozen_part);
  c.first_soft = store.first_soft;
  const ContactCounts counts{store.states, store.elastic_states, store.states - store.first_soft, store.pair.size()};
  if (counts.soft_states > 0) c.near = back_end.template allocate<ClosestApproach>("contact near", counts.soft_states);
  c.by.of_body = allocate_copy(back_end, "contact of bodies", store.of_body);
  c.by.part = allocate_copy(back_end, "contact parts", store.part);
  c.state = back_end.template allocate<ContactState>("contact states", store.states);
  c.by.wrench = back_end.template allocate<PairWrench>("contact wrenches", store.pair.size());
  c.by.held = allocate_copy(back_end, "contact held", store.held);
  if (store.held_pairs > 0)
    c.by.resistance = back_end.template allocate<Resistance>("contact resistance", store.held_pairs);
  if (plan.elastic_rounds > 0 && c.elastic_parts > 0)
    c.elastic_push = back_end.template allocate<ElasticPush>("contact elastic push", counts.elastic_states);
  return counts;
}

template <class B>
void reset_contact(B& back_end, ContactCounts counts, const ContactViews& c) {
  back_end.upload(c.state, std::vector<ContactState>(counts.states, no_contact()));
  back_end.upload(c.by.wrench, std::vector<PairWrench>(counts.pairs, no_wrench()));
  if (c.elastic_push != nullptr)
    back_end.upload(c.elastic_push, std::vector<ElasticPush>(counts.elastic_states, no_elastic_push()));
  if (counts.soft_states > 0)
    back_end.upload(c.near, std::vector<ClosestApproach>(counts.soft_states, ClosestApproach{0, 2}));
}

template <class B>
void allocate_change(B& back_end, const Scene& scene, const Plan& plan, StepViews& v) {
  const ChangeStore store(scene, plan);
  const std::size_t n = plan.slots, all = n * kMaxBonds;
  ChangeViews& c = v.change.views;
  c.count = plan.slots;
  c.slot_of = allocate_copy(back_end, "change slots", store.slot_of);
  c.group = allocate_copy(back_end, "change groups", store.group);
  c.shaped = allocate_copy(back_end, "change shaped", store.shaped);
  c.tag = allocate_copy(back_end, "change tags", store.tag);
  v.change.force_of = allocate_copy(back_end, "change forces of", store.force_of);
  c.x = back_end.template allocate<Packed>("change position", n);
  c.v = back_end.template allocate<Packed>("change velocity", n);
  c.solid = back_end.template allocate<real>("change solid fraction", n);
  c.before = back_end.template allocate<real>("change solid fraction before", n);
  c.set = back_end.template allocate<real>("change set", n);
  c.rotation = back_end.template allocate<Quat>("bond rotation", n);
  c.stress = back_end.template allocate<Mat3>("bond stress", n);
  c.correction = back_end.template allocate<Mat3>("bond correction", n);
  c.projection = back_end.template allocate<Mat3>("bond projection", n);
  c.soft = back_end.template allocate<real>("bond softness", n);
  c.force = back_end.template allocate<Packed>("bond force", n);
  c.bonds = back_end.template allocate<std::uint32_t>("bond counts", n);
  c.bond = back_end.template allocate<std::uint32_t>("bonds", all);
  c.own = back_end.template allocate<Packed>("bond vectors", all);
  c.other = back_end.template allocate<Packed>("bond vectors back", all);
  c.piece = back_end.template allocate<std::uint32_t>("pieces", n);
  c.acting = back_end.template allocate<std::uint32_t>("pieces that act", n);
  v.change.pieces.a = back_end.template allocate<std::uint32_t>("piece numbers", n);
  v.change.pieces.b = back_end.template allocate<std::uint32_t>("piece numbers in work", n);
  v.change.pieces.converged = back_end.template allocate<std::uint32_t>("piece rounds", kPieceRounds);
  v.change.medium = make_change_medium(scene, plan);
  if (!plan.rigidifies) return;
  RigidViews& r = v.change.rigid;
  r.root = back_end.template allocate<std::uint32_t>("rigid root", n);
  r.local = back_end.template allocate<Packed>("rigid local", n);
  r.push = back_end.template allocate<Packed>("rigid push", n);
  r.piece = back_end.template allocate<RigidPiece>("rigid pieces", n);
  r.list = back_end.template allocate<std::uint32_t>("rigid list", kMaxRigidPieces);
  r.past = back_end.template allocate<std::uint32_t>("rigid past threshold", n);
  r.whole = back_end.template allocate<std::uint32_t>("rigid whole", n);
  r.same = back_end.template allocate<std::uint32_t>("rigid same", n);
  r.last = back_end.template allocate<std::uint32_t>("rigid last", n);
  r.place = back_end.template allocate<std::uint32_t>("rigid place", n);
  r.roots = back_end.template allocate<std::uint32_t>("rigid roots", rigid_chunks(plan.slots));
}

template <class B>
void reset_change(B& back_end, const Scene& scene, const Plan& plan, const StepViews& v) {
  const ChangeStore store(scene, plan);
  const ChangeViews& c = v.change.views;
  back_end.upload(c.x, store.x);
  back_end.upload(c.v, store.v);
  back_end.upload(c.solid, store.solid);
  back_end.upload(c.before, store.solid);
  back_end.upload(c.set, store.set);
  back_end.upload(c.rotation, store.rotation);
  back_end.upload(c.correction, store.correction);
  back_end.upload(c.projection, store.projection);
  back_end.upload(c.soft, store.soft);
  back_end.upload(c.bonds, store.bonds);
  back_end.upload(c.bond, store.bond);
  back_end.upload(c.own, store.own);
  back_end.upload(c.other, store.other);
  back_end.upload(v.state.solid, store.fraction);
  back_end.upload(c.piece, store.piece);
  back_end.upload(c.acting, store.piece);
  back_end.upload(v.change.pieces.converged, std::vector<std::uint32_t>(kPieceRounds, 1));
  if (!plan.rigidifies) return;
  back_end.upload(v.change.rigid.root, std::vector<std::uint32_t>(plan.slots, kNone));
  back_end.upload(v.change.rigid.list, std::vector<std::uint32_t>(kMaxRigidPieces, kNone));
}

// Reads solid fractions and pieces for a snapshot. id: that of each particle in the state's order.
template <class B>
void snapshot_change(B& back_end, const Scene& scene, const Plan& plan, const StepViews& v,
                     const std::vector<std::uint32_t>& id, Snapshot& out) {
  std::vector<Solidity> solid(id.size());
  std::vector<std::uint32_t> piece(plan.slots);
  back_end.download(solid, v.state.solid);
  back_end.download(piece, v.change.views.piece);
  out.body_id = body_ids(scene, plan, piece);
  if (plan.rigidifies) {
    back_end.download(piece, v.change.rigid.root);
    out.rigid = rigid_particles(scene, plan, piece);
  }
  out.solid.resize(solid.size());
  for (std::size_t i = 0; i < solid.size(); ++i) out.solid[id[i]] = static_cast<float>(solid[i].K);
}

// Allocates the arrays of viscous stages once: a parameter that is set later may be the first to ask for them.
template <class B>
void allocate_viscosity(B& back_end, const Scene& scene, const Plan& plan, ViscosityViews& v) {
  if (v.stage[0] != nullptr) return;
  for (Packed*& stage : v.stage) stage = back_end.template allocate<Packed>("viscous velocity", scene.position.size());
  if (plan.geometry) v.drag = back_end.template allocate<WallDrag>("viscous walls", scene.position.size());
  if (!plan.moving) return;
  v.solid = back_end.template allocate<Packed>("viscous solid force", plan.force_count);
  v.body = back_end.template allocate<ViscousBody>("viscous bodies", scene.bodies.size());
}

template <class B>
void allocate_heat(B& back_end, const Scene& scene, const Plan& plan, StepViews& v) {
  v.heat.medium = make_heat_medium(scene, plan);
  v.heat.views.role = allocate_copy(back_end, "heat roles", heat_roles(scene));
  const std::vector<HeatZone> zones = make_heat_zones(scene);
  if (zones.empty()) return;
  v.heat.views.zones = static_cast<std::uint32_t>(zones.size());
  v.heat.views.zone = allocate_copy(back_end, "heat zones", zones);
  v.heat.views.zone_volume = back_end.template allocate<real>("heat zone volumes", zones.size());
}

template <class B>
void allocate_heat_walls(B& back_end, const Scene& scene, const ContactStore& store, const ContactFields& fields,
                         HeatStageViews& heat) {
  WallViews& walls = heat.solids.walls;
  walls.by.bodies = static_cast<std::uint32_t>(store.shaped.size());
  walls.body = allocate_copy(back_end, "heat wall bodies", store.shaped);
  walls.shape = fields.shape;
  walls.piece = fields.piece;
  walls.grid = fields.grid;
  heat.solids.temperature = allocate_copy(back_end, "heat wall temperatures", body_temperatures(scene));
  heat.views.wall = back_end.template allocate<HeatWall>("heat walls", scene.position.size());
}

}  // namespace palp
