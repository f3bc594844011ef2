// Everything that the stages of a step read and write: pointers into the back end's memory, and the constants of the
// plan. A group whose module the plan does not name has null pointers.
#pragma once

#include "sim_server/physics/cohesion.h"
#include "sim_server/physics/elastic_sleep.h"
#include "sim_server/physics/health.h"
#include "sim_server/physics/heat_walls.h"
#include "sim_server/physics/implicit_elastic.h"
#include "sim_server/physics/pieces.h"
#include "sim_server/physics/proxy.h"
#include "sim_server/physics/rigid_contact.h"
#include "sim_server/physics/rigid_pieces.h"
#include "sim_server/physics/sleep.h"
#include "sim_server/physics/viscosity.h"
#include "sim_server/physics/walls.h"

namespace palp {

// Which stages a haptic step has.
struct StepKind {
  bool flows = true;    // fluids move, by as many haptic steps as they take at once; else their push on bodies stays
  bool seldom = false;  // it conducts heat, judges what sleeps, or looks at the layers of particles (shift.h)
};

// The input of a haptic step.
struct InputViews {
  const Forcing* forcing = nullptr;
  const ProxyInput* proxy = nullptr;
};

struct FluidViews {
  Packed* wall = nullptr;          // ExtrapolateToWalls::wall
  Packed* acceleration = nullptr;  // by particle [m/s^2]
  Packed* shift_sums = nullptr;    // AdvanceDensity::shift_sums
  WallViews walls;
  ViscosityViews viscosity;
  CohesionMedium cohesion;
};

// The indices of the bodies that stages run over.
struct BodyLists {
  std::uint32_t reactive_count = 0, rigid_count = 0;
  const std::uint32_t* reactive = nullptr;  // those whose wrench is asked for
  const std::uint32_t* rigid = nullptr;
  const std::uint32_t* elastic = nullptr;
};

struct HeatStageViews {
  HeatMedium medium;
  HeatViews views;
  HeatWallViews solids;
};

struct ChangeStageViews {
  ChangeMedium medium;
  ChangeViews views;
  const std::uint32_t* force_of = nullptr;  // BondForce::force_of
  PieceViews pieces;
  RigidViews rigid;
};

struct HealthStageViews {
  HealthSums* part = nullptr;
  HealthSums* total = nullptr;
};

struct StepViews {
  std::uint32_t particles = 0, bodies = 0;
  InputViews input;
  ParticleView state, sorted;
  CellGrid grid;
  Medium medium;
  FluidViews fluid;
  BodyViews body;
  BodyLists list;
  ElasticViews elastic;
  ImplicitViews implicit;
  ContactViews contact;
  HeatStageViews heat;
  ChangeStageViews change;
  SleepViews sleep;
  ElasticSleepViews elastic_sleep;
  HealthStageViews health;

  // Returns the tags by which back ends pass over elastic particles that sleep; null where none can.
  const Tag* elastic_sleepers() const { return elastic_sleep.units > 0 ? elastic.tag : nullptr; }
};

}  // namespace palp
