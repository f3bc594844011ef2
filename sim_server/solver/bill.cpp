#include "sim_server/solver/bill.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim_server/geometry/point_grid.h"
#include "sim_server/scene/particle_reason.h"
#include "sim_server/scene/scene_heat.h"
#include "sim_server/solver/fluid_room.h"
#include "sim_server/solver/sub_steps.h"

namespace palp {
namespace {

std::string kind_of(const Body& body) {
  switch (body.type) {
    case BodyKind::fluid:
      return "fluid";
    case BodyKind::elastic:
      return "elastic";
    case BodyKind::rigid:
      return "rigid";
    default:
      return "static";
  }
}

// Returns the names of the bodies for which keep(index) holds: "'water', 'oil'".
template <class Keep>
std::string names_of(const Scene& scene, Keep&& keep) {
  std::string out;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (keep(b)) out += fmt::format("{}'{}'", out.empty() ? "" : ", ", scene.bodies[b].name);
  return out;
}

// Returns what the particles of a body that does not flow are there for.
std::vector<std::string> reasons_of_solid(const Scene& scene, const Plan& plan, std::size_t b) {
  const Body& body = scene.bodies[b];
  std::vector<std::string> reasons;
  if (body.type == BodyKind::elastic) reasons.emplace_back("elastic");
  if (is_wall_of_particles(scene, plan, b)) reasons.emplace_back("wall of a fluid");
  if (particle_reason(scene, b) == ParticleReason::adhesion) reasons.emplace_back("a fluid clings to it");
  if (plan.heat && !bounds_heat(scene, body)) {
    if (material_of(scene, body).conductivity > 0)
      reasons.emplace_back("conducts heat");
    else if (particle_reason(scene, b) == ParticleReason::temperature)
      reasons.emplace_back("heat zones may warm it");
  }
  const auto holds_on = [&](std::size_t other) {
    const auto& to = scene.bodies[other].bonded_to;
    return std::find(to.begin(), to.end(), b) != to.end();
  };
  if (const std::string bonded = names_of(scene, holds_on); !bonded.empty())
    reasons.push_back("is bonded to " + bonded);
  const auto by_springs = [&](std::size_t other) {
    return other != b && contact_between(scene, plan, b, other) == SolidContact::springs;
  };
  if (const std::string touched = names_of(scene, by_springs); !touched.empty())
    reasons.push_back((plan.method == Method::paper ? "contact by method \"paper\" with "
                                                    : "contact without a distance field with ") +
                      touched);
  return reasons;
}

// Counts the particles of static bodies that no fluid comes near (BillBody::out_of_reach).
void count_out_of_reach(const Scene& scene, const Plan& plan, std::vector<BillBody>& bodies) {
  if (!plan.fluid || plan.method == Method::paper) return;
  const std::vector<Eigen::Vector3d> reached = fluid_room(scene, plan);
  if (reached.empty()) return;
  // half of a cell's diagonal more, because fluid may be anywhere in its cell
  const double reach = plan.support + 0.87 * scene.spacing;
  const PeriodicBox box = box_of(scene);
  const PointGrid grid(reached, box, reach);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const bool wall_only = bodies[b].reasons == std::vector<std::string>{"wall of a fluid"};
    if (body.type != BodyKind::fixed || !wall_only) continue;
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
      bool near = false;
      grid.near(scene.position[i],
                [&](std::uint32_t c) { near = near || box.between(reached[c], scene.position[i]).norm() < reach; });
      bodies[b].out_of_reach += near ? 0 : 1;
    }
  }
}

// The stages' launches, how often they run, and what they took.
std::vector<BillStage> stages_of(const Footprint& footprint, const StageTimes& times) {
  std::vector<BillStage> out;
  double total = 0;
  for (const StageTimes::Stage& stage : times.stages) total += stage.seconds;
  for (const std::string& name : footprint.launches) {
    const auto known = std::find_if(out.begin(), out.end(), [&](const BillStage& one) { return one.name == name; });
    if (known != out.end()) {
      ++known->launches;
      continue;
    }
    out.push_back({name, 1, 1, 0, 0});
  }
  for (BillStage& stage : out) {
    const auto timed = std::find_if(times.stages.begin(), times.stages.end(),
                                    [&](const StageTimes::Stage& one) { return one.name == stage.name; });
    if (timed == times.stages.end() || timed->launches == 0) continue;
    stage.every = std::max<std::uint64_t>(1, stage.launches * times.steps / timed->launches);
    stage.seconds = timed->seconds / static_cast<double>(times.steps);
    stage.share = total > 0 ? timed->seconds / total : 0;
  }
  return out;
}

}  // namespace

std::uint64_t Bill::particles() const {
  std::uint64_t sum = 0;
  for (const BillBody& body : bodies) sum += body.particles;
  return sum;
}

std::size_t Bill::bytes() const {
  std::size_t sum = 0;
  for (const auto& [name, size] : arrays) sum += size;
  return sum;
}

double Bill::stage_seconds() const {
  double sum = 0;
  for (const BillStage& stage : stages) sum += stage.seconds;
  return sum;
}

std::vector<BillBody> bill_bodies(const Scene& scene, const Plan& plan) {
  std::vector<BillBody> out;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    BillBody line{body.name, kind_of(body), body.count, {}, 0};
    if (plan.changes[b])
      line.reasons.emplace_back("fluid that freezes, melts or sets");
    else if (body.type == BodyKind::fluid)
      line.reasons.emplace_back("fluid");
    else
      line.reasons = reasons_of_solid(scene, plan, b);
    out.push_back(std::move(line));
  }
  count_out_of_reach(scene, plan, out);
  return out;
}

std::vector<BillModule> bill_modules(const Scene& scene, const Plan& plan) {
  std::vector<BillModule> out;
  const auto add = [&](bool runs, const std::string& name, const std::string& why) {
    if (runs) out.push_back({name, why});
  };
  const auto bodies = [&](auto&& keep) { return names_of(scene, keep); };
  const auto material = [&](std::size_t b) -> const MaterialConfig& { return material_of(scene, scene.bodies[b]); };
  const auto kind = [&](BodyKind type) {
    return [&scene, type](std::size_t b) { return scene.bodies[b].type == type; };
  };
  const auto lasting = [&](std::size_t b) { return scene.bodies[b].type == BodyKind::elastic && !plan.changes[b]; };
  const auto fluids = bodies([&](std::size_t b) { return flows(scene, plan, b); });
  add(plan.neighbors, "neighbour lists",
      plan.fluid     ? "fluids"
      : plan.contact ? "contact by springs"
                     : "heat flows between neighbours");
  add(plan.fluid, plan.method == Method::paper ? "fluid by method \"paper\"" : "fluid", fluids);
  add(plan.shifts, "particle shifting",
      fmt::format("deep in {}, layers counted every {} haptic steps", fluids, plan.layer_interval));
  add(plan.walls, "walls by particles", bodies([&](std::size_t b) { return is_wall_of_particles(scene, plan, b); }));
  add(plan.geometry, "walls by geometry", bodies([&](std::size_t b) { return scene.bodies[b].contact != nullptr; }));
  add(plan.cohesion, "surface tension", bodies([&](std::size_t b) {
        return scene.bodies[b].type == BodyKind::fluid && (material(b).surface_tension > 0 || material(b).adhesion > 0);
      }));
  add(plan.viscous_stages > 0, "viscosity in stages",
      fmt::format("{} stages a sub-step in place of {:.0f} sub-steps", plan.viscous_stages, plan.explicit_sub_steps));
  add(plan.moving, "rigid bodies", bodies(kind(BodyKind::rigid)));
  add(plan.wrench, "wrenches",
      bodies([&](std::size_t b) { return std::count(plan.reactive.begin(), plan.reactive.end(), b) > 0; }));
  const auto touches = [&](SolidContact by) {
    return [&scene, &plan, by](std::size_t b) {
      for (std::size_t other = 0; other < scene.bodies.size(); ++other)
        if (other != b && contact_between(scene, plan, b, other) == by) return true;
      return false;
    };
  };
  add(plan.contact, "contact by springs", bodies(touches(SolidContact::springs)));
  add(plan.fields, "contact by distance fields",
      bodies([&](std::size_t b) { return touches(SolidContact::fields)(b) || plan.changes[b]; }));
  add(plan.elastic, plan.elastic_rounds > 0 ? "elasticity, implicit" : "elasticity, explicit",
      fmt::format("{}; {}", bodies(lasting), plan.elastic_choice));
  add(plan.plastic, "plastic flow",
      bodies([&](std::size_t b) { return lasting(b) && material(b).yield_stress.has_value(); }));
  add(plan.tears, "tearing", bodies([&](std::size_t b) { return lasting(b) && material(b).tear_strain.has_value(); }));
  add(plan.temperature && !plan.heat, "temperatures", "carried along, no heat flows");
  add(plan.heat, "heat", fmt::format("{} steps every {} haptic steps", plan.heat_steps, plan.heat_interval));
  add(plan.heat_walls, "heat at walls by geometry",
      bodies([&](std::size_t b) { return bounds_heat(scene, scene.bodies[b]); }));
  add(plan.sleeps, "sleep", fmt::format("what rests, judged every {} haptic steps", plan.sleep_interval));
  add(plan.change, "changes of state", bodies([&](std::size_t b) { return bool(plan.changes[b]); }));
  add(plan.rigidifies, "rigid pieces", bodies([&](std::size_t b) {
        return plan.changes[b] && (material(b).rigid_below || material(b).rigid_when_set);
      }));
  return out;
}

std::vector<BillLimit> bill_limits(const Scene& scene, const Plan& plan) {
  std::vector<BillLimit> out;
  const double step = 1 / scene.config.rate_hz;
  for (const StepLimit& limit : plan.limits) {
    const auto known = std::find_if(out.begin(), out.end(), [&](const BillLimit& one) {
      return one.limit.by == limit.by && one.limit.avoided_by == limit.avoided_by;
    });
    if (known != out.end() && known->limit.dt <= limit.dt) continue;
    if (known != out.end()) out.erase(known);
    out.push_back({limit, std::max(1.0, std::ceil(step / allowed_by(limit, scene.config.numerics) - 1e-9))});
  }
  std::stable_sort(out.begin(), out.end(), [&](const BillLimit& a, const BillLimit& b) {
    if (a.limit.avoided_by.empty() != b.limit.avoided_by.empty()) return a.limit.avoided_by.empty();
    return allowed_by(a.limit, scene.config.numerics) < allowed_by(b.limit, scene.config.numerics);
  });
  return out;
}

namespace {

Bill bill_of(const Simulation& simulation, const Plan& plan, const Footprint& footprint) {
  const Scene& scene = simulation.scene();
  Bill bill;
  bill.scene = scene.config.name;
  bill.numerics = simulation.numerics();
  bill.backend = simulation.backend_name();
  bill.spacing = scene.spacing;
  bill.bodies = bill_bodies(scene, plan);
  bill.modules = bill_modules(scene, plan);
  bill.sub_steps = plan.sub_steps;
  bill.step = 1 / scene.config.rate_hz;
  bill.dt = plan.dt;
  bill.limits = bill_limits(scene, plan);
  bill.arrays = footprint.arrays;
  return bill;
}

}  // namespace

Bill planned_bill(const Simulation& simulation) {
  return bill_of(simulation, make_plan(simulation.scene()), simulation.footprint());
}

Bill make_bill(Simulation& simulation, double seconds) {
  const Plan plan = make_plan(simulation.scene());
  simulation.step({});  // so that no first-time work is measured
  const StageTimes times = simulation.time_stages({}, seconds);
  const Footprint footprint = simulation.footprint();
  Bill bill = bill_of(simulation, plan, footprint);
  bill.stages = stages_of(footprint, times);
  bill.measured_steps = times.steps;
  bill.hints = bill_hints(simulation.scene(), plan, bill);
  return bill;
}

}  // namespace palp
