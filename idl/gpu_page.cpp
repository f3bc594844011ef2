#include "idl/gpu_page.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace palp {
namespace {

std::int64_t last_heard(const GpuUse& server) { return std::max(server.begun_ns.load(), server.ended_ns.load()); }
bool is_silent(const GpuUse& server, std::int64_t now_ns) { return now_ns - last_heard(server) > kGpuSilence; }

bool lives(std::int64_t process) { return kill(static_cast<pid_t>(process), 0) == 0 || errno != ESRCH; }

bool is_free(const GpuUse& server, std::int64_t now_ns) {
  const std::int64_t owner = server.owner;
  return owner == 0 || (is_silent(server, now_ns) && !lives(owner));
}

[[noreturn]] void fail(const std::string& name, int error) {
  throw std::runtime_error("shared memory " + name + " cannot be opened (" + std::strerror(error) +
                           "): simulation and viewer cannot take turns on their GPU");
}

}  // namespace

GpuGap gap_of(const GpuPage& page, std::int64_t now_ns) {
  GpuGap gap{0, kNever};
  for (const GpuUse& server : page.servers) {
    if (server.owner == 0 || is_silent(server, now_ns)) continue;
    // the end is written last and read first, so that it is never newer than what is read of the next step
    const std::int64_t ended = server.ended_ns;
    gap.since_ns = std::max(gap.since_ns, ended);
    const bool runs = server.begun_ns > ended;
    gap.until_ns = std::min(gap.until_ns, runs ? 0 : std::max<std::int64_t>(0, server.next_ns - kTurnToServer));
  }
  return gap;
}

bool in_use(const GpuPage& page, std::int64_t now_ns) {
  return !std::ranges::all_of(page.servers, [=](const GpuUse& server) { return is_free(server, now_ns); });
}

GpuUse* take_place(GpuPage& page, std::int64_t process, std::int64_t now_ns) {
  for (GpuUse& server : page.servers) {
    std::int64_t owner = server.owner;
    if (!is_free(server, now_ns)) continue;
    if (server.owner.compare_exchange_strong(owner, process)) return &server;
  }
  return nullptr;
}

void leave_place(GpuUse& place) {
  place.begun_ns = place.ended_ns = place.next_ns = 0;
  place.owner = 0;
}

void begin_step(GpuUse& place, std::int64_t now_ns) { place.begun_ns = now_ns; }

void end_step(GpuUse& place, std::int64_t now_ns, std::int64_t next_ns) {
  place.next_ns = next_ns;
  place.ended_ns = now_ns;
}

std::shared_ptr<GpuPage> open_gpu_page(const std::string& gpu) {
  // the number is that of the page's form
  const std::string name = "/palp-gpu-1-" + gpu;
  const int file = shm_open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) fail(name, errno);
  void* page = MAP_FAILED;
  if (ftruncate(file, sizeof(GpuPage)) == 0)  // what is new is zero, what was there stays
    page = mmap(nullptr, sizeof(GpuPage), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  const int error = errno;
  close(file);
  if (page == MAP_FAILED) fail(name, error);
  return {static_cast<GpuPage*>(page), [](GpuPage* mapped) { munmap(mapped, sizeof(GpuPage)); }};
}

}  // namespace palp
