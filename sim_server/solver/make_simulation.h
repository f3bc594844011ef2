// What each back end offers to the factory (simulation.cpp).
#pragma once

#include <memory>
#include <string>

#include "sim_server/solver/simulation.h"

namespace palp {

std::unique_ptr<Simulation> make_cpu_simulation(const Scene& scene);

// Throws std::runtime_error: built without CUDA, no device, too little memory.
std::unique_ptr<Simulation> make_cuda_simulation(const Scene& scene);
// Empty when a CUDA device can be used, else why not.
std::string cuda_unavailable();

}  // namespace palp
