#include "sim_server/solver/state_change_plan.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "config/error.h"
#include "sim_server/geometry/point_grid.h"
#include "sim_server/scene/scene_heat.h"

namespace palp {
namespace {

// Returns the solid fraction and the share that has set, at the start, at a temperature [K].
std::pair<double, double> start_fraction(const Scene& scene, const Body& body, double temperature) {
  const MaterialConfig& m = material_of(scene, body);
  const double set = m.cooking_temperature && body.type == BodyKind::elastic ? 1 : 0;
  const bool frozen = m.melting_temperature && temperature <= *m.melting_temperature;
  return {std::max(set, frozen ? 1.0 : 0.0), set};
}

// Returns by slot the least slot that bonds lead to; kNone for those that are not solid.
std::vector<std::uint32_t> start_pieces(const ChangeStore& store) {
  std::vector<std::uint32_t> piece(store.solid.size(), kNone), open;
  for (std::uint32_t first = 0; first < piece.size(); ++first) {
    if (piece[first] != kNone || !(store.solid[first] > kPieceSolid)) continue;
    piece[first] = first;
    open.push_back(first);
    while (!open.empty()) {
      const std::uint32_t i = open.back();
      open.pop_back();
      for (std::uint32_t b = 0; b < store.bonds[i]; ++b) {
        const std::uint32_t j = store.bond[std::size_t(i) * kMaxBonds + b];
        if (piece[j] != kNone || !(store.solid[j] > kPieceSolid)) continue;
        piece[j] = first;
        open.push_back(j);
      }
    }
  }
  return piece;
}

// Bonds the particles that are solid at the start, as they lie. body, place: by slot.
void bond_solids(const Scene& scene, const Plan& plan, const std::vector<std::uint32_t>& body,
                 const std::vector<Eigen::Vector3d>& place, ChangeStore& store) {
  store.bonds.assign(plan.slots, 0);
  store.bond.assign(std::size_t(plan.slots) * kMaxBonds, 0);
  store.own.assign(store.bond.size(), Packed{});
  store.other.assign(store.bond.size(), Packed{});
  store.correction.assign(plan.slots, Mat3::Zero());
  store.projection.assign(plan.slots, Mat3::Zero());
  store.soft.assign(plan.slots, real(1));  // at the start particles lie on lattices
  const PeriodicBox box = box_of(scene);
  const PointGrid grid(place, box, plan.change_support);
  const WendlandC2 kernel = WendlandC2::with_support(static_cast<real>(plan.change_support));
  for (std::uint32_t i = 0; i < plan.slots; ++i) {
    Mat3 moment = Mat3::Zero();
    if (!(store.solid[i] > real(0))) continue;
    std::vector<std::uint32_t> near;
    grid.near(place[i], [&](std::uint32_t j) {
      const bool tools = !plan.changes[body[i]] && !plan.changes[body[j]] && body[i] != body[j];
      const double r = box.between(place[j], place[i]).norm();
      if (j != i && store.solid[j] > real(0) && plan.group[body[i]] == plan.group[body[j]] && !tools &&
          r < 0.999 * plan.change_support)
        near.push_back(j);
    });
    std::sort(near.begin(), near.end());
    near.resize(std::min<std::size_t>(near.size(), kMaxBonds));
    for (const std::uint32_t j : near) {
      const std::size_t at = std::size_t(i) * kMaxBonds + store.bonds[i]++;
      const Vec3 X = box.between(place[j], place[i]).cast<real>();
      store.bond[at] = j;
      store.own[at] = pack(X, 0);
      store.other[at] = pack(-X, 0);
      moment += (store.solid[j] * store.x[j].w * kernel.F(X.norm()) * X) * X.transpose();
    }
    const GradientCorrection<real> c = gradient_correction(moment, kFlatBonds);
    store.correction[i] = c.inverse;
    store.projection[i] = c.projection;
  }
}

// Returns the index of the material of a body's bonds: a tool has that of the matter around it.
std::uint32_t bonded_material(const Scene& scene, const Plan& plan, std::uint32_t body) {
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b)
    if (plan.changes[b] && (b == body || (!plan.changes[body] && plan.group[b] == plan.group[body])))
      return scene.bodies[b].material;
  return scene.bodies[body].material;
}

}  // namespace

void plan_slots(const Scene& scene, Plan& plan) {
  const std::size_t count = scene.bodies.size();
  plan.changes.assign(count, false);
  plan.slot_first.assign(count, kNone);
  std::vector<bool> held(count, false);
  for (std::uint32_t b = 0; b < count; ++b) {
    if (!changes_state(scene, scene.bodies[b])) continue;
    plan.changes[b] = held[b] = plan.change = true;
    const MaterialConfig& m = material_of(scene, scene.bodies[b]);
    if (m.rigid_below || m.rigid_when_set) plan.rigidifies = true;
    for (const std::uint32_t other : scene.bodies[b].bonded_to) held[other] = true;
  }
  if (!plan.change) return;
  for (const ProbeConfig& probe : scene.config.probes)
    for (std::uint32_t b = 0; b < count; ++b)
      if (probe.quantity == Quantity::body && plan.changes[b] && probe.body == scene.bodies[b].name)
        throw ConfigError(
            fmt::format("{}: probe '{}' asks for the pose of '{}', which changes state; expected a rigid, "
                        "static or lasting elastic body",
                        scene.config.path, probe.name, probe.body));
  for (std::uint32_t b = 0; b < count; ++b) {
    if (!held[b]) continue;
    plan.slot_first[b] = plan.slots;
    plan.slots += scene.bodies[b].count;
  }
}

ChangeStore::ChangeStore(const Scene& scene, const Plan& plan)
    : slot_of(scene.bodies.size(), kNoDifference), group(plan.group), force_of(scene.bodies.size(), kNoDifference) {
  std::vector<std::uint32_t> particle(plan.slots);
  std::vector<std::uint32_t> body(plan.slots);
  std::vector<Eigen::Vector3d> place(plan.slots);
  tag.resize(plan.slots);
  x.resize(plan.slots);
  v.resize(plan.slots);
  solid.resize(plan.slots);
  set.resize(plan.slots);
  rotation.assign(plan.slots, Quat::Identity());
  fraction.assign(scene.position.size(), Solidity{0, kNone});
  for (const Body& b : scene.bodies) shaped.push_back(plan.fields && b.contact != nullptr ? 1 : 0);
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& from = scene.bodies[b];
    if (plan.slot_first[b] == kNone) continue;
    slot_of[b] = plan.slot_first[b] - from.first;
    if (plan.force_first[b] != kNone) force_of[b] = plan.force_first[b] - plan.slot_first[b];
    const BodyKind kind = plan.changes[b] ? BodyKind::fluid : from.type;
    for (std::uint32_t k = 0; k < from.count; ++k) {
      const std::uint32_t s = plan.slot_first[b] + k, p = from.first + k;
      particle[s] = p;
      body[s] = b;
      place[s] = scene.position[p];
      tag[s] = make_tag(kind, bonded_material(scene, plan, b), b);
      x[s] = pack(scene.position[p].cast<real>(), static_cast<real>(scene.volume[p]));
      v[s] = pack(scene.velocity[p].cast<real>(), 0);
      const auto [now, lasting] =
          plan.changes[b] ? start_fraction(scene, from, scene.temperature[p]) : std::pair(1.0, 1.0);
      solid[s] = static_cast<real>(now);
      set[s] = static_cast<real>(lasting);
    }
  }
  bond_solids(scene, plan, body, place, *this);
  piece = start_pieces(*this);
  for (std::uint32_t s = 0; s < plan.slots; ++s) fraction[particle[s]] = {solid[s], piece[s]};
}

namespace {

// Calls f(body, particle, number) for the slots that have a number.
template <class F>
void each_numbered(const Scene& scene, const Plan& plan, const std::vector<std::uint32_t>& number, F&& f) {
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b)
    for (std::uint32_t k = 0; plan.slot_first[b] != kNone && k < scene.bodies[b].count; ++k)
      if (const std::uint32_t n = number[plan.slot_first[b] + k]; n != kNone) f(b, scene.bodies[b].first + k, n);
}

}  // namespace

std::vector<std::uint32_t> body_ids(const Scene& scene, const Plan& plan, const std::vector<std::uint32_t>& piece) {
  std::vector<std::uint32_t> out = scene.body, name(piece.size(), kNone);
  each_numbered(scene, plan, piece, [&](std::uint32_t b, std::uint32_t, std::uint32_t id) {
    if (!plan.changes[b]) name[id] = std::min(name[id], b);
  });
  // bodies and their slots have the same order, so a piece's first particle comes first
  each_numbered(scene, plan, piece, [&](std::uint32_t, std::uint32_t p, std::uint32_t id) {
    if (name[id] == kNone) name[id] = static_cast<std::uint32_t>(scene.bodies.size()) + p;
  });
  each_numbered(scene, plan, piece, [&](std::uint32_t b, std::uint32_t p, std::uint32_t id) {
    if (plan.changes[b]) out[p] = name[id];
  });
  return out;
}

std::vector<std::uint8_t> rigid_particles(const Scene& scene, const Plan& plan,
                                          const std::vector<std::uint32_t>& root) {
  std::vector<std::uint8_t> out(scene.position.size(), 0);
  each_numbered(scene, plan, root, [&](std::uint32_t, std::uint32_t p, std::uint32_t) { out[p] = 1; });
  return out;
}

}  // namespace palp
