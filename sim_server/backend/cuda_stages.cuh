// The stages of fluids and of changes of state (solver/step.h) on the GPU. They are compiled in a file of their own,
// cuda_fluids.cu, beside all others, so that nvcc works on both at once: cuda.cu declares them with DECLARE = extern,
// cuda_fluids.cu instantiates them with an empty DECLARE. More files would cost more, for each parses all headers.
#pragma once

#include "sim_server/backend/cuda_backend.cuh"
#include "sim_server/solver/step.h"

#define PALP_FLUID_STAGES(DECLARE)                                                                     \
  DECLARE template void viscous_stages(Cuda&, const Plan&, const StepViews&, real);                    \
  DECLARE template void fluid_stages<LoneFluid>(Cuda&, const Plan&, const StepViews&, real, NoBonds);  \
  DECLARE template void fluid_stages<OneFluid>(Cuda&, const Plan&, const StepViews&, real, NoBonds);   \
  DECLARE template void fluid_stages<OneFluid>(Cuda&, const Plan&, const StepViews&, real, Bonded);    \
  DECLARE template void fluid_stages<ManyFluids>(Cuda&, const Plan&, const StepViews&, real, NoBonds); \
  DECLARE template void fluid_stages<ManyFluids>(Cuda&, const Plan&, const StepViews&, real, Bonded);  \
  DECLARE template void paper_stages(Cuda&, const StepViews&, NoBonds);                                \
  DECLARE template void paper_stages(Cuda&, const StepViews&, Bonded);                                 \
  DECLARE template void bond_stages(Cuda&, const StepViews&);                                          \
  DECLARE template void change_stages(Cuda&, const Plan&, const StepViews&);
