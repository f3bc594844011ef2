#include "sim_server/gpu_turns.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include "idl/clock.h"

namespace palp {

GpuTurns::GpuTurns(Simulation& simulation) : simulation_(simulation) {
  const std::string gpu = simulation.gpu();
  if (gpu.empty()) return;
  try {
    page_ = open_gpu_page(gpu);
    place_ = take_place(*page_, getpid(), now_ns());
    if (place_ == nullptr) spdlog::warn("more servers share this GPU than viewers wait for: they delay its steps");
  } catch (const std::exception& error) {
    spdlog::warn("{}", error.what());
  }
}

GpuTurns::~GpuTurns() {
  if (place_ != nullptr) leave_place(*place_);
}

void GpuTurns::begin_step(std::int64_t now_ns) {
  if (place_ != nullptr) palp::begin_step(*place_, now_ns);
}

void GpuTurns::end_step(std::int64_t now_ns, std::int64_t next_ns) {
  if (place_ != nullptr) palp::end_step(*place_, now_ns, next_ns);
}

bool GpuTurns::viewer_draws(std::int64_t now_ns) const {
  constexpr std::int64_t kSecond = 1'000'000'000;
  return page_ != nullptr && now_ns - page_->drawn_ns < kSecond;
}

void GpuTurns::take_back() {
  if (place_ != nullptr && page_->drawn_ns > place_->begun_ns) simulation_.take_gpu();
}

}  // namespace palp
