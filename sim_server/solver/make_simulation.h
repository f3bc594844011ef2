// The back ends' parts of the factory (simulation.cpp).
#pragma once

#include <memory>
#include <string>

#include "sim_server/solver/simulation.h"

namespace palp {

std::unique_ptr<Simulation> make_cpu_simulation(const Scene& scene);

// Makes a simulation on the GPU. Throws std::runtime_error: built without CUDA, no device, too little memory.
std::unique_ptr<Simulation> make_cuda_simulation(const Scene& scene);
// Returns why no CUDA device can be used; empty when one can.
std::string cuda_unavailable();
// Returns the name of the device that make_cuda_simulation would use: "NVIDIA H100 80GB HBM3". Empty when none can be.
std::string cuda_device_name();

}  // namespace palp
