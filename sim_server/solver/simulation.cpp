#include "sim_server/solver/simulation.h"

#include "sim_server/solver/make_simulation.h"

namespace palp {

std::unique_ptr<Simulation> make_simulation(const Scene& scene, Backend backend) {
  if (backend == Backend::automatic) backend = cuda_unavailable().empty() ? Backend::cuda : Backend::cpu;
  return backend == Backend::cuda ? make_cuda_simulation(scene) : make_cpu_simulation(scene);
}

}  // namespace palp
