// One haptic step, every stage in order. B is a back end (backend/cpu.cpp, backend/cuda.cu): it iterates, sorts and
// reduces, and knows no physics.
#pragma once

#include "sim_server/physics/boundary.h"
#include "sim_server/physics/cohesion.h"
#include "sim_server/physics/frozen_contact.h"
#include "sim_server/physics/health.h"
#include "sim_server/physics/heat.h"
#include "sim_server/physics/implicit_elastic.h"
#include "sim_server/physics/integrate.h"
#include "sim_server/physics/paper.h"
#include "sim_server/physics/pieces.h"
#include "sim_server/physics/proxy.h"
#include "sim_server/physics/rigid.h"
#include "sim_server/physics/tear.h"
#include "sim_server/physics/viscous_bodies.h"
#include "sim_server/solver/plan.h"

namespace palp {

// Everything the stages read and write: pointers into the back end's memory, and the constants of the plan.
struct StepViews {
  std::uint32_t particles = 0, bodies = 0, reactive_count = 0, rigid_count = 0;
  ParticleView state, sorted;
  CellGrid grid;
  Medium medium;
  BodyViews body;
  ElasticViews elastic;
  ImplicitViews implicit;
  ContactViews contact;
  const std::uint32_t* reactive = nullptr;
  const std::uint32_t* rigid = nullptr;
  const std::uint32_t* elastic_bodies = nullptr;
  Packed* wall = nullptr;
  Packed* acceleration = nullptr;
  HealthSums* health_part = nullptr;
  HealthSums* health = nullptr;
  const Forcing* forcing = nullptr;
  const ProxyInput* proxy = nullptr;
  HeatMedium heat_medium;
  HeatViews heat;
  ViscosityViews viscosity;
  CohesionMedium cohesion;
  ChangeMedium change_medium;
  ChangeViews change;
  const std::uint32_t* change_force_of = nullptr;  // BondForce::force_of
  PieceViews pieces;
  RigidViews rigid_pieces;
};

// Whether two particles ever act on each other: stored neighbour lists leave out the pairs that do not.
struct Interacts {
  bool all;  // method "paper": a solid's own particles count in its density; heat: they conduct
  bool contact;
  PALP_HD bool operator()(Tag a, Tag b) const {
    if (all || a.is_fluid() || b.is_fluid()) return true;
    return contact && a.body() != b.body() && (a.kind() != BodyKind::fixed || b.kind() != BodyKind::fixed);
  }
};

struct EveryPair {
  PALP_HD bool operator()(Tag, Tag) const { return true; }
};

inline Medium without_viscosity(Medium medium) {
  for (Material& material : medium.material) material.viscosity = 0;
  return medium;
}

// After all other forces of fluids, before the bodies' wrenches are added up.
template <class B>
void viscous_stages(B& back_end, const Plan& plan, const StepViews& v, real elapsed) {
  const WendlandC2 kernel = WendlandC2::with_support(v.medium.support);
  const std::uint32_t n = v.particles;
  const real reach = static_cast<real>(stage_reach(plan.viscous_stages));
  back_end.for_each_team("viscosity begins", n,
                         BeginViscosity{v.state, v.body, v.grid, kernel, v.medium, v.viscosity, reach});
  if (plan.moving) {
    back_end.for_each_block(
        "viscous bodies begin", v.rigid_count,
        BeginViscousBodies{v.body, v.rigid, v.proxy, v.forcing, v.viscosity, v.medium.dt, elapsed, reach});
    back_end.for_each("viscous bodies move", n, SpreadBodies{v.state, v.body, v.viscosity, 0});
  }
  for (int j = 1; j <= plan.viscous_stages; ++j) {
    const StageNumbers numbers = stage_numbers(j, plan.viscous_stages, plan.dt);
    back_end.for_each_team(
        "viscosity", n, ViscousStage{v.state, v.body, v.grid, kernel, v.medium, v.viscosity, v.acceleration, numbers});
    if (!plan.moving || numbers.last) continue;
    back_end.for_each_block("viscous bodies", v.rigid_count, ViscousBodyStage{v.body, v.rigid, v.viscosity, numbers});
    back_end.for_each("viscous bodies move", n, SpreadBodies{v.state, v.body, v.viscosity, 1 - numbers.from});
  }
}

// Fluids: OneFluid or ManyFluids. bonds: NoBonds, or Bonded where something changes state.
template <class Fluids, class B, class Bonds>
void fluid_stages(B& back_end, const Plan& plan, const StepViews& v, real elapsed, Bonds bonds) {
  const WendlandC2 kernel = WendlandC2::with_support(v.medium.support);
  const std::uint32_t n = v.particles;
  const Medium medium = plan.viscous_stages > 0 ? without_viscosity(v.medium) : v.medium;
  back_end.for_each_team("density", n,
                         AdvanceDensity<Fluids, Bonds>{v.sorted, v.state, v.grid, kernel, v.medium, v.forcing, bonds});
  if (plan.solids && plan.fluid)
    back_end.for_each_team("walls", n,
                           ExtrapolateToWalls<Bonds>{v.state, v.grid, kernel, v.medium, v.forcing, v.wall, bonds});
  if (plan.fluid)
    back_end.for_each_team(
        "fluid force", n,
        FluidForce<Fluids, Bonds>{v.state, v.wall, v.grid, kernel, medium, v.forcing, v.acceleration, bonds});
  if (plan.wrench)
    back_end.for_each_team("solid force", n,
                           SolidForce<Bonds>{v.state, v.wall, v.body, v.grid, kernel, medium, plan.contact, bonds});
  if (plan.cohesion)
    back_end.for_each_team(
        "cohesion", n, Cohere{v.state, v.body, v.grid, kernel.support, v.medium.uniform, v.cohesion, v.acceleration});
  if (plan.viscous_stages > 0) viscous_stages(back_end, plan, v, elapsed);
}

template <class B, class Bonds>
void paper_stages(B& back_end, const StepViews& v, Bonds bonds) {
  const Mueller kernel = Mueller::with_support(v.medium.support);
  back_end.for_each_team("density (paper)", v.particles, PaperDensity{v.sorted, v.state, v.grid, kernel, v.medium});
  back_end.for_each_team(
      "force (paper)", v.particles,
      PaperForce<Bonds>{v.state, v.body, v.grid, kernel, v.medium, v.forcing, v.acceleration, bonds});
}

// Forces of the bonds, onto those of fluids and bodies.
template <class B>
void bond_stages(B& back_end, const StepViews& v) {
  const WendlandC2 kernel = WendlandC2::with_support(v.change_medium.support);
  const std::uint32_t n = v.change.count;
  back_end.for_each_group("bond strain", n, BondStrain{v.change, v.grid, kernel, v.medium});
  back_end.for_each_group("bond force", n, BondForce{v.change, v.body, v.change_force_of, v.grid, kernel, v.medium});
}

// Which of what is solid hangs together.
template <class B>
void piece_stages(B& back_end, const StepViews& v) {
  const std::uint32_t n = v.change.count;
  back_end.for_each("pieces begin", n, BeginPieces{v.change, v.pieces});
  back_end.for_each("pieces begin", kPieceRounds, BeginRounds{v.pieces});
  for (std::uint32_t round = 0; round < kPieceRounds; ++round) {
    back_end.for_each("pieces join", n, JoinPieces{v.change, v.pieces, round});
    back_end.for_each("pieces join", n, JumpPieces{v.pieces, round});
  }
  back_end.for_each("pieces", n, NamePieces{v.change, v.pieces});
}

// Which pieces are rigid.
template <class B>
void rigidify_stages(B& back_end, const StepViews& v) {
  const std::uint32_t n = v.change.count, chunks = std::max(rigid_chunks(n), kMaxRigidPieces);
  back_end.for_each("rigid find", v.particles, FindPast{v.state, v.change, v.rigid_pieces, v.change_medium});
  back_end.for_each("rigid find", n, FindWhole{v.change, v.rigid_pieces, v.grid});
  back_end.for_each("rigid list", chunks, CountRoots{v.change, v.rigid_pieces, n});
  back_end.for_each("rigid list", n, ListRoots{v.change, v.rigid_pieces});
  back_end.for_each("rigid assign", n, AssignRigid{v.change, v.rigid_pieces});
  back_end.for_each_block("rigid form", kMaxRigidPieces, FormRigid{v.change, v.rigid_pieces, v.grid});
}

// After heat has flown.
template <class B>
void change_stages(B& back_end, const Plan& plan, const StepViews& v) {
  const WendlandC2 kernel = WendlandC2::with_support(v.change_medium.support);
  back_end.for_each("solid fractions", v.particles, ChangeFractions{v.state, v.change, v.change_medium});
  back_end.for_each("bonds", v.particles, ChangeBonds{v.state, v.change, v.grid, kernel, v.change_medium});
  back_end.for_each("pieces act", v.particles, ActPieces{v.state, v.change});
  piece_stages(back_end, v);
  if (plan.rigidifies) rigidify_stages(back_end, v);
}

template <class B>
void heat_stages(B& back_end, const Plan& plan, const StepViews& v) {
  const WendlandC2 kernel = WendlandC2::with_support(v.medium.support);
  const BodyState* bodies = v.body.body;
  if (v.heat.zones > 0)
    back_end.for_each_block("heat zones", v.heat.zones, MeasureHeatZones{v.state, v.grid, bodies, v.heat, v.particles});
  for (int s = 0; s < plan.heat_steps; ++s) {
    back_end.for_each_team("heat", v.particles, ConductHeat{v.state, v.grid, kernel, v.heat_medium, bodies, v.heat});
    back_end.for_each("temperature", v.particles, UpdateTemperature{v.state, v.heat_medium, v.heat});
  }
}

// Onto the forces from outside.
template <class B>
void elastic_stages(B& back_end, const Plan& plan, const StepViews& v) {
  const WendlandC2 kernel = WendlandC2::with_support(static_cast<real>(plan.elastic_support));
  const std::uint32_t n = v.elastic.count;
  const bool accurate = plan.method == Method::accurate;
  if (plan.tears) back_end.for_each_group("elastic tears", n, TearBonds{v.elastic, v.grid, kernel, v.medium});
  if (plan.plastic)
    back_end.for_each_group("elastic strain", n, ElasticStrain<true>{v.elastic, v.body, v.grid, kernel, v.medium});
  else if (accurate)
    back_end.for_each_group("elastic strain", n, ElasticStrain<false>{v.elastic, v.body, v.grid, kernel, v.medium});
  else
    back_end.for_each_group("elastic strain (paper)", n, PaperStrain{v.elastic, v.body, v.grid, kernel, v.medium});
  back_end.for_each_group("elastic force", n,
                          ElasticForce{v.elastic, v.body, v.grid, kernel, v.medium, accurate, plan.meets});
}

// In place of elastic_stages: after all other forces, and sets velocities.
template <class B>
void implicit_elastic_stages(B& back_end, const StepViews& v) {
  const std::uint32_t n = v.elastic.count, parts = v.implicit.parts;
  back_end.for_each("implicit begin", n, BeginImplicit{v.elastic, v.implicit, v.body, v.medium, v.grid, v.forcing});
  back_end.for_each_group("implicit strain", n, StrainAhead{v.elastic, v.implicit, v.medium});
  back_end.for_each_group("implicit force", n, ForceAhead{v.elastic, v.implicit, v.medium});
  for (std::uint32_t round = 0; round < v.implicit.rounds; ++round) {
    back_end.for_each_group("implicit strain", n, StrainChange{v.elastic, v.implicit, v.medium, round});
    back_end.for_each_group("implicit force", n, ForceChange{v.elastic, v.implicit, v.medium, round});
    back_end.for_each_block("implicit sums", parts, SumRound{v.elastic, v.implicit, round});
    back_end.for_each_block("implicit round", parts, AdvanceRound{v.elastic, v.implicit, round});
  }
  if (v.implicit.free_bodies > 0)
    back_end.for_each_block("implicit momenta", v.implicit.free_bodies, KeepMomenta{v.elastic, v.implicit, v.body});
  back_end.for_each("implicit end", n, EndImplicit{v.elastic, v.implicit, v.body, v.medium});
}

// Forces between bodies and within fluids.
template <class B>
void meeting_stages(B& back_end, const Plan& plan, const StepViews& v, real elapsed) {
  const auto sort = [&](auto interacts) {
    back_end.sort_into_cells(v.state, v.sorted, v.particles, v.grid, static_cast<real>(plan.support),
                             static_cast<real>(plan.skin), interacts);
  };
  if (plan.solids)
    sort(Interacts{plan.method == Method::paper || plan.heat, plan.contact});
  else
    sort(EveryPair{});
  const auto forces = [&](auto bonds) {
    if (plan.method == Method::paper)
      paper_stages(back_end, v, bonds);
    else if (plan.one_fluid)
      fluid_stages<OneFluid>(back_end, plan, v, elapsed, bonds);
    else
      fluid_stages<ManyFluids>(back_end, plan, v, elapsed, bonds);
  };
  if (plan.change)
    forces(Bonded{v.change.group, v.change.shaped});
  else
    forces(NoBonds{});
}

// By distance fields: wrenches of pairs, and forces on soft particles, onto those that act already.
template <class B>
void contact_stages(B& back_end, const StepViews& v) {
  const PairPoints points{v.contact, v.body.body, v.grid, v.medium.dt};
  if (v.contact.pairs > 0 && !v.contact.few)
    back_end.for_each_block("contact depth", v.contact.pairs, MeasureContact{points});
  if (v.contact.pairs > 0) back_end.for_each_block("contact", v.contact.pairs, MeetBodies{points});
  if (v.contact.elastic_parts > 0)
    back_end.for_each_block(
        "elastic contact", v.contact.elastic_parts,
        MeetParticles<ElasticMatter>{points, v.contact.elastic_part, {v.elastic, v.body, v.medium}, v.medium.spacing});
  if (v.contact.frozen_parts > 0)
    back_end.for_each_block("frozen contact", v.contact.frozen_parts,
                            MeetParticles<FrozenMatter>{points,
                                                        v.contact.frozen_part,
                                                        {v.change, v.medium, v.contact.near, v.contact.first_frozen},
                                                        v.medium.spacing});
}

template <class B>
void sub_step(B& back_end, const Plan& plan, const StepViews& v, real elapsed, bool heat) {
  if (plan.meets) meeting_stages(back_end, plan, v, elapsed);
  if (heat) heat_stages(back_end, plan, v);
  if (heat && plan.change) change_stages(back_end, plan, v);
  if (plan.change) bond_stages(back_end, v);
  const bool implicit = plan.elastic_rounds > 0;
  if (implicit && !plan.meets) back_end.for_each("implicit clear", v.elastic.count, ClearForce{v.body});
  if (plan.elastic && !implicit) elastic_stages(back_end, plan, v);
  if (plan.fields) contact_stages(back_end, v);
  if (implicit) implicit_elastic_stages(back_end, v);
  if (plan.wrench) back_end.for_each_block("wrench", v.reactive_count, ReduceWrench{v.body, v.contact.by, v.reactive});
  if (plan.moving)
    back_end.for_each(
        "bodies", v.rigid_count,
        AdvanceBodies{v.body.body, v.contact.by, v.rigid, v.proxy, v.forcing, v.grid, v.medium.dt, elapsed});
  if (implicit)
    back_end.for_each("move elastic", v.elastic.count, MoveImplicit{v.elastic, v.body, v.medium});
  else if (plan.elastic)
    back_end.for_each("move elastic", v.elastic.count, MoveElastic{v.elastic, v.body, v.medium, v.grid, v.forcing});
  if (plan.rigidifies) {
    back_end.for_each("rigid push", v.particles, PushRigid{v.state, v.acceleration, v.change, v.rigid_pieces});
    back_end.for_each_block("rigid move", kMaxRigidPieces,
                            AdvanceRigid{v.rigid_pieces, v.grid, v.forcing, v.medium.dt});
  }
  const MoveParticles move{v.state,        v.acceleration, v.body,   v.elastic, v.change,
                           v.rigid_pieces, v.grid,         v.medium, v.forcing};
  if (plan.meets)
    back_end.move("move", v.particles, move);
  else
    back_end.for_each("move", v.particles, move);
}

// heat: this haptic step is the one in plan.heat_interval that conducts.
template <class B>
void step(B& back_end, const Plan& plan, const StepViews& v, bool heat) {
  if (plan.wrench) back_end.for_each("begin", v.bodies, BeginStep{v.body.body});
  for (int s = 0; s < plan.sub_steps; ++s)
    sub_step(back_end, plan, v, static_cast<real>((s + 1) * plan.dt), heat && s + 1 == plan.sub_steps);
  if (plan.elastic)
    back_end.for_each_block("elastic bodies", static_cast<std::uint32_t>(plan.elastic_bodies.size()),
                            MeasureElastic{v.elastic, v.body, v.elastic_bodies});
  back_end.for_each_block("health", kHealthBlocks,
                          MeasureHealth{v.state, v.medium, v.grid, v.particles, v.health_part});
  back_end.for_each_block("health", 1, CollectHealth{v.health_part, v.health, v.implicit.left});
}

}  // namespace palp
