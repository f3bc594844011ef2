#include "sim_server/backend/thread_waits.h"

#include <unistd.h>

#include <cstdlib>

namespace palp {

void wait_asleep(char** argv) {
  if (std::getenv("OMP_WAIT_POLICY") != nullptr || std::getenv("GOMP_SPINCOUNT") != nullptr) return;
  if (setenv("GOMP_SPINCOUNT", "300", 0) == 0) execv("/proc/self/exe", argv);  // returns only if it cannot: spin, then
}

}  // namespace palp
