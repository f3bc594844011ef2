#include "sim_server/backend/cuda_stages.cuh"

namespace palp {

PALP_SOLID_STAGES()

}  // namespace palp
