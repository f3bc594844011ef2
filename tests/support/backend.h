// The back end that a test binary is built for: the CPU, or with PALP_TEST_CUDA the GPU. Without a GPU all tests of the
// binary are skipped with the reason.
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "sim_server/backend/make.h"
#include "sim_server/simulation.h"
#include "tests/support/validation.h"

namespace palp::testing {

#ifdef PALP_TEST_CUDA
inline constexpr Backend kBackend = Backend::cuda;
#else
inline constexpr Backend kBackend = Backend::cpu;
#endif

inline std::unique_ptr<Simulation> simulate(const Scene& scene, Backend backend = kBackend) {
  auto simulation = make_simulation(scene, backend);
  computed_with(simulation->numerics());
  return simulation;
}

}  // namespace palp::testing
