#include "sim_server/backend/cuda_stages.cuh"

namespace palp {

PALP_FLUID_STAGES()

}  // namespace palp
