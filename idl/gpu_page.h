// A page of shared memory for each GPU, in which the servers that compute on it say when they need it, and viewers that
// they draw on it. A GPU works for one process at a time and lets each finish what it has begun, so whoever draws must
// not begin what a step would have to wait for. But for its last two no function allocates, locks, waits or throws.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

namespace palp {

// [ns] Before its step a server has the GPU turn to it, which takes an H100 0.15 ms after another process's work; from
// then on nobody else may begin anything.
inline constexpr std::int64_t kTurnToServer = 200'000;
// [ns] Whoever has been silent for so long has ended, was killed, or is paused, and counts no longer.
inline constexpr std::int64_t kGpuSilence = 20'000'000;
inline constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

// A server's word on its steps, in times of now_ns(). All zero: it is nobody's.
struct GpuUse {
  std::atomic<std::int64_t> owner{0};                              // process, while it is taken
  std::atomic<std::int64_t> begun_ns{0}, ended_ns{0}, next_ns{0};  // of the last step; when the next one is to begin
};

struct GpuPage {
  std::array<GpuUse, 4> servers;          // a fifth one is not waited for
  std::atomic<std::int64_t> drawn_ns{0};  // when a viewer last gave the GPU work
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "a killed process must leave no lock");

// When the GPU is free for others.
struct GpuGap {
  std::int64_t since_ns = 0;  // end of the last step; 0: there is no server
  std::int64_t until_ns = 0;  // kNever without a server; 0 while a step runs
};
GpuGap gap_of(const GpuPage& page, std::int64_t now_ns);

// Returns whether a server that lives has a place, one that is paused included.
bool in_use(const GpuPage& page, std::int64_t now_ns);

// Takes a place for this process, one that is free or whose owner has died; null when there is none.
GpuUse* take_place(GpuPage& page, std::int64_t process, std::int64_t now_ns);
void leave_place(GpuUse& place);
void begin_step(GpuUse& place, std::int64_t now_ns);
void end_step(GpuUse& place, std::int64_t now_ns, std::int64_t next_ns);

// Returns the 16 bytes by which CUDA, OpenGL and Vulkan all know a GPU as hexadecimal digits; empty if all are zero.
inline std::string gpu_identity(const void* uuid) {
  const auto* bytes = static_cast<const unsigned char*>(uuid);
  std::string digits;
  for (int k = 0; k < 16; ++k)
    for (const int half : {bytes[k] >> 4, bytes[k] & 15}) digits += "0123456789abcdef"[half];
  return digits.find_first_not_of('0') == std::string::npos ? std::string() : digits;
}
// Opens the page of that GPU, for processes of this user; the first one makes it, and it stays. Throws
// std::runtime_error with one sentence.
std::shared_ptr<GpuPage> open_gpu_page(const std::string& gpu);

}  // namespace palp
