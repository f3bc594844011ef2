// One haptic step, every stage in order. B is a back end (backend/cpu.cpp, backend/cuda.cu): it iterates, sorts and
// reduces, and knows no physics.
#pragma once

#include "sim_server/physics/boundary.h"
#include "sim_server/physics/conjugate_gradients.h"
#include "sim_server/physics/elastic_contact.h"
#include "sim_server/physics/elastic_momenta.h"
#include "sim_server/physics/frozen_contact.h"
#include "sim_server/physics/integrate.h"
#include "sim_server/physics/paper.h"
#include "sim_server/physics/tear.h"
#include "sim_server/physics/viscous_bodies.h"
#include "sim_server/physics/wall_drag.h"
#include "sim_server/solver/listed_pairs.h"
#include "sim_server/solver/look_stages.h"
#include "sim_server/solver/plan.h"
#include "sim_server/solver/step_views.h"

namespace palp {

inline Medium without_viscosity(Medium medium) {
  for (Material& material : medium.material) material.viscosity = 0;
  return medium;
}

// Applies viscosity in stages, after all other forces of fluids and before the bodies' wrenches are added up.
template <class B>
void viscous_stages(B& back_end, const Plan& plan, const StepViews& v, real elapsed) {
  const FluidKernel kernel = v.medium.kernel;
  const std::uint32_t n = v.particles;
  const real reach = static_cast<real>(stage_reach(plan.viscous_stages));
  const WallViews& walls = v.fluid.walls;
  if (plan.geometry) {
    back_end.for_each("viscous walls", n, MeasureWallDrag{v.state, v.body, walls, v.grid, v.medium, v.fluid.viscosity});
    if (plan.moving)
      back_end.for_each_block("viscous walls", walls.by.parts,
                              SumWallDrag{v.state, v.body, walls, v.grid, v.medium, v.fluid.viscosity, n});
  }
  back_end.for_each_team("viscosity begins", n,
                         BeginViscosity{v.state, v.body, v.grid, kernel, v.medium, v.fluid.viscosity, reach});
  if (plan.sleeps) back_end.for_each("viscosity at rest", n, RestStages{v.state, v.fluid.viscosity});
  if (plan.moving) {
    back_end.for_each_block("viscous bodies begin", v.list.rigid_count,
                            BeginViscousBodies{v.body, v.list.rigid, v.input.proxy, v.input.forcing, v.fluid.viscosity,
                                               walls.by, v.medium.dt, elapsed, reach});
    back_end.for_each("viscous bodies move", n, SpreadBodyVelocities{v.state, v.body, v.fluid.viscosity, 0});
  }
  for (int j = 1; j <= plan.viscous_stages; ++j) {
    const StageNumbers numbers = stage_numbers(j, plan.viscous_stages, plan.dt);
    back_end.for_each_team(
        "viscosity", n,
        ViscousStage{v.state, v.body, v.grid, kernel, v.medium, v.fluid.viscosity, v.fluid.acceleration, numbers});
    if (plan.geometry && plan.wrench)
      back_end.for_each_block("viscous walls", walls.by.parts,
                              WallDragReaction{v.state, v.body, walls, v.grid, v.fluid.viscosity, n, numbers});
    if (!plan.moving || numbers.last) continue;
    back_end.for_each_block("viscous bodies", v.list.rigid_count,
                            ViscousBodyStage{v.body, v.list.rigid, v.fluid.viscosity, walls.by, numbers});
    back_end.for_each("viscous bodies move", n,
                      SpreadBodyVelocities{v.state, v.body, v.fluid.viscosity, 1 - numbers.from});
  }
}

// Computes the forces of fluids by method "accurate". Fluids: OneFluid or ManyFluids. bonds: NoBonds, or Bonded where
// something changes state.
template <class Fluids, class B, class Bonds>
void fluid_stages(B& back_end, const Plan& plan, const StepViews& v, real elapsed, Bonds bonds) {
  const FluidKernel kernel = v.medium.kernel;
  const std::uint32_t n = v.particles;
  const Medium medium = plan.viscous_stages > 0 ? without_viscosity(v.medium) : v.medium;
  if (plan.geometry)
    back_end.for_each_part(
        "walls by geometry", v.fluid.walls.by.parts,
        MeasureWalls<Bonds>{v.sorted, v.body, v.fluid.walls, v.grid, medium, v.input.forcing, n, bonds});
  with_type(kernel, [&]<class Kernel>(const Kernel& of_type) {
    back_end.for_each_team(
        "density", n,
        AdvanceDensity<Fluids, Bonds, Kernel>{v.sorted, v.state, v.grid, of_type, v.medium, v.input.forcing,
                                              v.fluid.walls.slope, v.fluid.walls.rate, bonds, v.fluid.shift_sums});
  });
  if (plan.walls)
    back_end.for_each_team(
        "walls", n, ExtrapolateToWalls<Bonds>{v.state, v.grid, kernel, v.medium, v.input.forcing, v.fluid.wall, bonds});
  if (plan.fluid)
    with_type(kernel, [&]<class Kernel>(const Kernel& of_type) {
      back_end.for_each_team("fluid force", n,
                             FluidForce<Fluids, Bonds, Kernel>{v.state, v.fluid.wall, v.grid, of_type, medium,
                                                               v.input.forcing, v.fluid.acceleration, bonds});
    });
  if (plan.geometry)
    back_end.for_each_part("wall force", v.fluid.walls.by.parts,
                           WallForce<Bonds>{v.state, v.body, v.fluid.walls, v.grid, medium, v.input.forcing, n,
                                            v.fluid.acceleration, bonds});
  if (plan.wrench && plan.force_count > 0)
    back_end.for_each_team(
        "solid force", n,
        SolidForce<Bonds>{v.state, v.fluid.wall, v.body, v.grid, kernel, medium, plan.contact, bonds});
  if (plan.cohesion)
    back_end.for_each_team("cohesion", n,
                           CohesionForce{v.state, v.body, v.grid, kernel.support, v.medium.uniform, v.fluid.cohesion,
                                         v.fluid.acceleration});
  if (plan.viscous_stages > 0) viscous_stages(back_end, plan, v, elapsed);
}

// Computes the forces of fluids and between bodies by method "paper".
template <class B, class Bonds>
void paper_stages(B& back_end, const StepViews& v, Bonds bonds) {
  const Mueller kernel = Mueller::with_support(v.medium.kernel.support);
  back_end.for_each_team("density (paper)", v.particles, PaperDensity{v.sorted, v.state, v.grid, kernel, v.medium});
  back_end.for_each_team(
      "force (paper)", v.particles,
      PaperForce<Bonds>{v.state, v.body, v.grid, kernel, v.medium, v.input.forcing, v.fluid.acceleration, bonds});
}

// Adds the forces of the bonds to those of fluids and bodies.
template <class B>
void bond_stages(B& back_end, const StepViews& v) {
  const WendlandC2 kernel = WendlandC2::with_support(v.change.medium.support);
  const std::uint32_t n = v.change.views.count;
  back_end.for_each_group("bond strain", n, BondStrain{v.change.views, v.grid, kernel, v.medium});
  back_end.for_each_group("bond force", n,
                          BondForce{v.change.views, v.body, v.change.force_of, v.grid, kernel, v.medium});
}

// Numbers the pieces that solid matter hangs together in.
template <class B>
void piece_stages(B& back_end, const StepViews& v) {
  const std::uint32_t n = v.change.views.count;
  back_end.for_each("pieces begin", n, BeginPieces{v.change.views, v.change.pieces});
  back_end.for_each("pieces begin", kPieceRounds, BeginRounds{v.change.pieces});
  for (std::uint32_t round = 0; round < kPieceRounds; ++round) {
    back_end.for_each("pieces join", n, JoinPieces{v.change.views, v.change.pieces, round});
    back_end.for_each("pieces join", n, JumpPieces{v.change.pieces, round});
  }
  back_end.for_each("pieces", n, NamePieces{v.change.views, v.change.pieces});
}

// Finds the pieces that are rigid.
template <class B>
void rigidify_stages(B& back_end, const StepViews& v) {
  const std::uint32_t n = v.change.views.count, chunks = std::max(rigid_chunks(n), kMaxRigidPieces);
  back_end.for_each("rigid find", v.particles,
                    MarkPastThreshold{v.state, v.change.views, v.change.rigid, v.change.medium});
  back_end.for_each("rigid find", n, MarkWholePieces{v.change.views, v.change.rigid, v.grid});
  back_end.for_each("rigid list", chunks, CountRoots{v.change.views, v.change.rigid, n});
  back_end.for_each("rigid list", n, ListRoots{v.change.views, v.change.rigid});
  back_end.for_each("rigid assign", n, AssignRigid{v.change.views, v.change.rigid});
  back_end.for_each_block("rigid form", kMaxRigidPieces, FormRigid{v.change.views, v.change.rigid, v.grid});
}

// Changes the state of matter after heat has flown.
template <class B>
void change_stages(B& back_end, const Plan& plan, const StepViews& v) {
  const WendlandC2 kernel = WendlandC2::with_support(v.change.medium.support);
  back_end.for_each("solid fractions", v.particles, ChangeFractions{v.state, v.change.views, v.change.medium});
  back_end.for_each("bonds", v.particles, ChangeBonds{v.state, v.change.views, v.grid, kernel, v.change.medium});
  back_end.for_each("pieces act", v.particles, ApplyPieces{v.state, v.change.views});
  piece_stages(back_end, v);
  if (plan.rigidifies) rigidify_stages(back_end, v);
}

// Advances heat to the end of this haptic step, in plan.heat_steps steps.
template <class B>
void heat_stages(B& back_end, const Plan& plan, const StepViews& v) {
  const FluidKernel kernel = v.medium.kernel;
  const BodyState* bodies = v.body.body;
  if (v.heat.views.zones > 0)
    back_end.for_each_large("heat zones", v.heat.views.zones,
                            MeasureHeatZones{v.state, v.grid, bodies, v.heat.views, v.particles});
  if (plan.heat_walls)
    back_end.for_each("heat walls", v.particles,
                      MeasureHeatWalls{v.state, bodies, v.heat.solids, v.grid, v.medium, v.heat.views});
  for (int s = 0; s < plan.heat_steps; ++s) {
    back_end.for_each_team("heat", v.particles,
                           ConductHeat{v.state, v.grid, kernel, v.heat.medium, bodies, v.heat.views});
    back_end.for_each("temperature", v.particles, UpdateTemperature{v.state, v.heat.medium, v.heat.views});
  }
}

// Adds the elastic forces to those from outside.
template <class B>
void elastic_stages(B& back_end, const Plan& plan, const StepViews& v) {
  const WendlandC2 kernel = WendlandC2::with_support(static_cast<real>(plan.elastic_support));
  const std::uint32_t n = v.elastic.count;
  const bool accurate = plan.method == Method::accurate;
  const Tag* sleepers = v.elastic_sleepers();
  if (plan.tears) back_end.for_each_group("elastic tears", n, TearBonds{v.elastic, v.grid, kernel, v.medium}, sleepers);
  if (plan.plastic)
    back_end.for_each_group("elastic strain", n, ElasticStrain<true>{v.elastic, v.body, v.grid, kernel, v.medium},
                            sleepers);
  else if (accurate)
    back_end.for_each_group("elastic strain", n, ElasticStrain<false>{v.elastic, v.body, v.grid, kernel, v.medium},
                            sleepers);
  else
    back_end.for_each_group("elastic strain (paper)", n, PaperStrain{v.elastic, v.body, v.grid, kernel, v.medium},
                            sleepers);
  back_end.for_each_group("elastic force", n,
                          ElasticForce{v.elastic, v.body, v.grid, kernel, v.medium, accurate, plan.neighbors},
                          sleepers);
}

inline ElasticTouching elastic_touching(const StepViews& v, real elapsed) {
  return {{v.contact, v.body.body, v.grid, v.input.forcing, v.medium.dt},
          v.elastic,
          v.body,
          v.medium,
          v.input.proxy,
          elapsed};
}

template <class B>
void count_elastic_contacts(B& back_end, const StepViews& v, real elapsed) {
  if (v.contact.elastic_on_rigid)
    back_end.for_each_block("elastic contacts", v.contact.elastic_parts,
                            CountElasticContacts{elastic_touching(v, elapsed)});
}

// Computes contact of explicit elastic bodies with rigid and fixed ones, after all other forces on their particles.
template <class B>
void elastic_contact_stages(B& back_end, const StepViews& v, real elapsed) {
  if (v.contact.elastic_parts == 0) return;
  count_elastic_contacts(back_end, v, elapsed);
  back_end.for_each_block("elastic contact", v.contact.elastic_parts, ElasticContact{elastic_touching(v, elapsed)});
}

// Solves elasticity and contact of its bodies implicitly after all other forces, in place of elastic_stages and
// elastic_contact_stages, and sets velocities.
template <class B>
void implicit_elastic_stages(B& back_end, const StepViews& v, real elapsed) {
  const std::uint32_t n = v.elastic.count, parts = v.implicit.parts, touching = v.contact.elastic_parts;
  const Tag* sleepers = v.elastic_sleepers();
  back_end.for_each("implicit begin", n,
                    BeginImplicit{v.elastic, v.implicit, v.body, v.medium, v.grid, v.input.forcing}, sleepers);
  back_end.for_each_group("implicit strain", n, PredictedStrain{v.elastic, v.implicit, v.medium}, sleepers);
  back_end.for_each_group("implicit force", n, PredictedForce{v.elastic, v.implicit, v.medium}, sleepers);
  if (touching > 0) {
    count_elastic_contacts(back_end, v, elapsed);
    back_end.for_each_block("elastic contact", touching, BeginElasticContact{elastic_touching(v, elapsed), v.implicit});
  }
  if (touching > 0 && v.implicit.free_bodies > 0)
    back_end.for_each_large("implicit rigid", v.implicit.free_bodies, BeginRigid{v.elastic, v.implicit, v.body});
  back_end.for_each("implicit begin", n, BeginSolve{v.implicit}, sleepers);
  for (std::uint32_t round = 0; round < v.implicit.rounds; ++round) {
    back_end.for_each_group("implicit strain", n, StrainChange{v.elastic, v.implicit, v.medium, round}, sleepers);
    back_end.for_each_group("implicit force", n, ForceChange{v.elastic, v.implicit, v.medium, round}, sleepers);
    back_end.for_each_block("implicit sums", parts, SumRound{v.elastic, v.implicit, round, sleepers});
    back_end.for_each_block("implicit round", parts, AdvanceRound{v.elastic, v.implicit, round, sleepers});
  }
  if (touching > 0)
    back_end.for_each_block("elastic contact", touching, EndElasticContact{elastic_touching(v, elapsed), v.implicit});
  if (v.implicit.free_bodies > 0)
    back_end.for_each_large("implicit momenta", v.implicit.free_bodies,
                            ConserveMomenta{v.elastic, v.implicit, v.body, v.medium.dt});
  back_end.for_each("implicit end", n, EndImplicit{v.elastic, v.implicit, v.body, v.medium}, sleepers);
}

// Sorts the particles and computes the forces between bodies and within fluids.
template <class B>
void particle_stages(B& back_end, const Plan& plan, const StepViews& v, real elapsed) {
  const auto sort = [&](auto interacts) {
    back_end.sort_into_cells(v.state, v.sorted, v.particles, v.grid, static_cast<real>(plan.support),
                             static_cast<real>(plan.skin), interacts);
  };
  const Interacts interacts{{}, plan.method == Method::paper || plan.heat, plan.contact, plan.cohesion};
  if (v.fluid.walls.thin)
    sort(InteractsInSight{interacts,
                          {v.fluid.walls, v.body.body, v.grid, static_cast<real>(plan.support + plan.skin),
                           static_cast<real>(kSightNear) * v.medium.spacing}});
  else if (plan.solids)
    sort(interacts);
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
    forces(Bonded{v.change.views.group, v.change.views.shaped});
  else if (plan.method == Method::accurate && v.medium.uniform)
    fluid_stages<LoneFluid>(back_end, plan, v, elapsed, NoBonds{});
  else
    forces(NoBonds{});
}

// Computes contact of rigid and fixed bodies by distance fields, and of matter that changes state with them: wrenches
// of pairs, and forces on particles, added to those that act already.
template <class B>
void contact_stages(B& back_end, const StepViews& v) {
  const PairPoints points{v.contact, v.body.body, v.grid, v.input.forcing, v.medium.dt};
  const std::uint32_t pairs = v.contact.by.rigid_pairs;
  if (!v.contact.single_pass) back_end.for_each_block("contact depth", pairs, MeasureContact{points});
  back_end.for_each_block("contact", pairs, RigidContact{points});
  if (v.contact.frozen_parts > 0)
    back_end.for_each_block("frozen contact", v.contact.frozen_parts, FrozenContact{points, v.change.views, v.medium});
}

// Runs a sub-step, which ends `elapsed` after the start of the haptic step [s].
template <class B>
void sub_step(B& back_end, const Plan& plan, const StepViews& v, real elapsed, bool flows, bool heat) {
  StepViews fluids = v;
  fluids.medium.dt = static_cast<real>(plan.fluid_interval * plan.dt);
  const bool particles = plan.neighbors && flows;
  const auto bonds = [&] {
    if (plan.change) bond_stages(back_end, v);
  };
  const auto contact = [&] {
    if (plan.fields) contact_stages(back_end, v);
  };
  // these and the fluids' stages ask nothing of each other where no forces on bodies' particles are added up
  const bool some = plan.change || plan.fields;
  const bool beside = some && particles && plan.force_count == 0 && !(heat && plan.change);
  if (beside)
    back_end.beside([&] {
      bonds();
      contact();
    });
  if (particles) particle_stages(back_end, plan, fluids, elapsed);
  if (heat) heat_stages(back_end, plan, v);
  if (heat && plan.change) change_stages(back_end, plan, v);
  if (!beside) bonds();
  const bool implicit = plan.elastic_rounds > 0;
  if (implicit && !plan.neighbors)
    back_end.for_each("implicit clear", v.elastic.count, ClearForce{v.body}, v.elastic_sleepers());
  if (plan.elastic && !implicit) elastic_stages(back_end, plan, v);
  if (beside)
    back_end.join();
  else
    contact();
  if (plan.fields && !implicit) elastic_contact_stages(back_end, v, elapsed);
  if (implicit) implicit_elastic_stages(back_end, v, elapsed);
  if (plan.wrench)
    back_end.for_each_large(
        "wrench", v.list.reactive_count,
        ReduceWrench{v.body, v.contact.by, v.list.reactive, v.fluid.walls.by, v.elastic_sleepers()});
  if (plan.moving)
    back_end.for_each("bodies", v.list.rigid_count,
                      AdvanceBodies{v.body.body, v.contact.by, v.list.rigid, v.input.proxy, v.input.forcing, v.grid,
                                    v.medium.dt, elapsed});
  if (implicit)
    back_end.for_each("move elastic", v.elastic.count, MoveImplicit{v.elastic, v.body, v.medium}, v.elastic_sleepers());
  else if (plan.elastic)
    back_end.for_each("move elastic", v.elastic.count,
                      MoveElastic{v.elastic, v.body, v.medium, v.grid, v.input.forcing}, v.elastic_sleepers());
  if (plan.rigidifies) {
    back_end.for_each("rigid push", v.particles,
                      GatherRigidForces{v.state, v.fluid.acceleration, v.change.views, v.change.rigid});
    back_end.for_each_block("rigid move", kMaxRigidPieces,
                            AdvanceRigid{v.change.rigid, v.grid, v.input.forcing, v.medium.dt});
  }
  const MoveParticles move{v.state,       v.fluid.acceleration, v.fluid.shift_sums, v.body,
                           v.elastic,     v.change.views,       v.change.rigid,     v.grid,
                           fluids.medium, v.input.forcing};
  if (particles)
    back_end.move("move", v.particles, move);
  else if (!plan.neighbors)
    back_end.for_each("move", v.particles, move, v.elastic_sleep.units > 0 ? v.state.tag : nullptr);
}

// Stills what has come to rest and wakes what is stirred, for the next haptic step.
template <class B>
void sleep_stages(B& back_end, const Plan& plan, const StepViews& v) {
  const std::uint32_t blocks = v.sleep.blocks();
  if (blocks > 0) {
    const auto reach = static_cast<real>(plan.support + plan.skin);
    back_end.for_each_block("sleep", v.list.rigid_count, MarkBodies{v.grid, v.sleep, v.body.body, v.list.rigid, reach});
    back_end.for_each_group("sleep", blocks, JudgeMotion{v.state, v.grid, v.sleep, v.input.forcing});
  }
  const int ring = plan.fluid ? 2 : 1;  // fluid asks for the pressure that a body's particles show
  back_end.for_each_large("sleep of bodies", v.elastic_sleep.units,
                          JudgeElastic{v.state, v.elastic, v.implicit, v.elastic_sleep, v.sleep, v.grid, v.medium,
                                       v.body.body, v.list.rigid, v.list.rigid_count, v.input.forcing, ring});
  back_end.for_each_group(
      "sleep", blocks,
      Settle{v.state, v.sorted, v.grid, v.sleep, v.body.body, v.elastic_sleep.units > 0 ? v.elastic : ElasticViews{}});
}

// Runs a haptic step.
template <class B>
void step(B& back_end, const Plan& plan, const StepViews& v, StepKind kind) {
  const bool heat = plan.heat && kind.seldom;
  if (plan.wrench) back_end.for_each("begin", v.bodies, BeginStep{v.body.body});
  for (int s = 0; s < plan.sub_steps; ++s)
    sub_step(back_end, plan, v, static_cast<real>((s + 1) * plan.dt), kind.flows, heat && s + 1 == plan.sub_steps);
  if (plan.elastic)
    back_end.for_each_large("elastic bodies", static_cast<std::uint32_t>(plan.elastic_bodies.size()),
                            MeasureElastic{v.elastic, v.body, v.list.elastic});
  if (plan.shifts && kind.seldom) look_stages(back_end, v);
  if (plan.sleeps && kind.seldom) sleep_stages(back_end, plan, v);
  if (v.particles == 0 || !kind.flows) return;  // bodies are judged by the host
  const std::uint32_t parts = health_parts(v.particles);
  back_end.for_each_block("health", parts, MeasureHealth{v.state, v.medium, v.grid, v.particles, v.health.part});
  back_end.for_each_block("health", 1, CollectHealth{v.health.part, parts, v.health.total, v.implicit.unsolved});
}

}  // namespace palp
