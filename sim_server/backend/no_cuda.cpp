// Stands in for cuda.cu in a build without CUDA.
#include <stdexcept>

#include "sim_server/solver/make_simulation.h"

namespace palp {

std::string cuda_unavailable() {
  return "this build has no CUDA back end: install the CUDA Toolkit and build again, or use --backend cpu";
}

std::string cuda_device_name() { return ""; }

std::unique_ptr<Simulation> make_cuda_simulation(const Scene&) { throw std::runtime_error(cuda_unavailable()); }

}  // namespace palp
