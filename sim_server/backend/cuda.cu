#include "sim_server/backend/cuda_stages.cuh"
#include "sim_server/solver/make_simulation.h"
#include "sim_server/solver/simulation_on.h"

namespace palp {

PALP_FLUID_STAGES(extern)

std::string cuda_unavailable() {
  int devices = 0;
  const cudaError_t error = cudaGetDeviceCount(&devices);
  if (error != cudaSuccess)
    return std::string("no CUDA device can be used (") + cudaGetErrorString(error) + "): use --backend cpu";
  return devices > 0 ? "" : "this host has no CUDA device: use --backend cpu";
}

std::string cuda_device_name() {
  int device = 0;
  cudaDeviceProp properties{};
  if (cudaGetDevice(&device) != cudaSuccess || cudaGetDeviceProperties(&properties, device) != cudaSuccess) return "";
  return properties.name;
}

std::unique_ptr<Simulation> make_cuda_simulation(const Scene& scene) {
  if (const std::string why = cuda_unavailable(); !why.empty()) throw std::runtime_error(why);
  return std::make_unique<SimulationOn<Cuda>>(scene);
}

}  // namespace palp
