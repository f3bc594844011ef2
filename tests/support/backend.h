// The back end that a test binary is linked for. Without a GPU all tests of a binary for the GPU are skipped with the
// reason.
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "sim_server/solver/make_simulation.h"
#include "sim_server/solver/simulation.h"
#include "tests/support/validation.h"

namespace palp::test {

// The GPU where backend.cpp was compiled with PALP_TEST_CUDA, else the CPU: nothing else differs between the binaries.
Backend tested_backend();

inline std::unique_ptr<Simulation> simulate(const Scene& scene, Backend backend = tested_backend()) {
  auto simulation = make_simulation(scene, backend);
  computed_with(simulation->numerics());
  return simulation;
}

// Returns a frame of the simulation as it is now. None other may be on its way.
inline Frame frame_of(Simulation& simulation, ScalarField field) {
  EXPECT_TRUE(simulation.begin_frame(field));
  Frame frame;
  while (!simulation.take_frame(frame)) {
  }
  return frame;
}

}  // namespace palp::test
