#include "sim_server/backend/cuda_stages.cuh"

namespace palp {

PALP_ONE_FLUID_STAGES(extern)
PALP_MANY_FLUIDS_STAGES()

}  // namespace palp
