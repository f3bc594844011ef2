// The stages of a step (solver/step.h) on the GPU in groups, each of which is compiled in a file of its own, so that
// nvcc works on several at once. Where the whole step is compiled the groups are declared with DECLARE = extern; the
// file of a group instantiates it with an empty DECLARE.
#pragma once

#include "sim_server/backend/cuda_backend.cuh"
#include "sim_server/solver/step.h"

#define PALP_ONE_FLUID_STAGES(DECLARE)                                              \
  DECLARE template void viscous_stages(Cuda&, const Plan&, const StepViews&, real); \
  DECLARE template void fluid_stages<OneFluid>(Cuda&, const Plan&, const StepViews&, real, NoBonds);

#define PALP_MANY_FLUIDS_STAGES(DECLARE)                                                               \
  DECLARE template void fluid_stages<ManyFluids>(Cuda&, const Plan&, const StepViews&, real, NoBonds); \
  DECLARE template void paper_stages(Cuda&, const StepViews&, NoBonds);

#define PALP_CHANGE_STAGES(DECLARE)                                                                   \
  DECLARE template void fluid_stages<OneFluid>(Cuda&, const Plan&, const StepViews&, real, Bonded);   \
  DECLARE template void fluid_stages<ManyFluids>(Cuda&, const Plan&, const StepViews&, real, Bonded); \
  DECLARE template void paper_stages(Cuda&, const StepViews&, Bonded);                                \
  DECLARE template void bond_stages(Cuda&, const StepViews&);                                         \
  DECLARE template void change_stages(Cuda&, const Plan&, const StepViews&);

#define PALP_SOLID_STAGES(DECLARE)                                            \
  DECLARE template void heat_stages(Cuda&, const Plan&, const StepViews&);    \
  DECLARE template void elastic_stages(Cuda&, const Plan&, const StepViews&); \
  DECLARE template void implicit_elastic_stages(Cuda&, const StepViews&);     \
  DECLARE template void contact_stages(Cuda&, const StepViews&);
