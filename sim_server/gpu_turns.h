// The server's turns on a GPU that viewers draw on, too (idl/gpu_page.h).
#pragma once

#include <memory>

#include "idl/gpu_page.h"
#include "sim_server/solver/simulation.h"

namespace palp {

// On a CPU, and where the page cannot be had, it does nothing. No call but the constructor allocates or locks.
class GpuTurns {
 public:
  // simulation must outlive it. Warns when there is a GPU and no page for it.
  explicit GpuTurns(Simulation& simulation);
  ~GpuTurns();
  GpuTurns(const GpuTurns&) = delete;
  GpuTurns& operator=(const GpuTurns&) = delete;

  void begin_step(std::int64_t now_ns);
  // next_ns: when the next step is to begin.
  void end_step(std::int64_t now_ns, std::int64_t next_ns);
  // Returns whether a viewer draws on the GPU: it has in the last second.
  bool viewer_draws(std::int64_t now_ns) const;
  // Takes the GPU back from a viewer that has drawn since the last step began; to be called kTurnToServer before the
  // next one.
  void take_back();

 private:
  Simulation& simulation_;
  std::shared_ptr<GpuPage> page_;  // null: there is nothing to share
  GpuUse* place_ = nullptr;        // in it; null: there is no page or no place
};

}  // namespace palp
