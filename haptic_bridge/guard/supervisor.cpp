#include "haptic_bridge/guard/supervisor.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "idl/clock.h"

namespace palp {
namespace {

constexpr int kLookMs = 10;     // how often the heartbeat is looked at
constexpr int kPriority = 90;   // above the loop's
constexpr char kInOrder = 'q';  // the bridge ends as it should

[[noreturn]] void fail(const char* what) {
  throw std::runtime_error(std::string("the supervisor cannot be started: ") + what + ": " + std::strerror(errno));
}

enum class End { in_order, died, hangs };

// heartbeat null: only what ends the bridge is waited for.
End wait_for_end(int pipe, Heartbeat* heartbeat, std::int64_t hang_ns) {
  for (;;) {
    pollfd look{pipe, POLLIN, 0};
    if (poll(&look, 1, heartbeat != nullptr ? kLookMs : -1) > 0) {
      char word = 0;
      const ssize_t n = read(pipe, &word, 1);
      if (n < 0 && errno == EINTR) continue;
      return n == 1 && word == kInOrder ? End::in_order : End::died;
    }
    if (heartbeat != nullptr && heartbeat->take_if_silent(now_ns(), hang_ns)) return End::hangs;
  }
}

void tell(const std::string& what) { std::fprintf(stderr, "palp-haptic-bridge supervisor: %s\n", what.c_str()); }

// The other process. Never returns.
[[noreturn]] void supervise(int pipe, Heartbeat& heartbeat, std::int64_t hang_ns,
                            const std::function<void()>& power_off, const std::function<std::string()>& save) {
  prctl(PR_SET_NAME, "palp_supervisor");
  setsid();  // a terminal's Ctrl-C is for the bridge
  for (const int s : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(s, SIG_IGN);
  const sched_param priority{kPriority};
  sched_setscheduler(0, SCHED_FIFO, &priority);  // where it is allowed
  End end = wait_for_end(pipe, &heartbeat, hang_ns);
  if (end != End::in_order && power_off) {
    try {
      power_off();
      tell((end == End::died ? "the bridge has died"
                             : "the loop has stood still for " + std::to_string(hang_ns / 1'000'000) + " ms") +
           ": the arm was powered off");
    } catch (const std::exception& error) {
      tell(std::string("the arm could not be powered off: ") + error.what());
    }
  }
  // a bridge that was killed may fall silent long before the system closes its pipe
  if (end == End::hangs) end = wait_for_end(pipe, nullptr, 0);
  if (end == End::died && save) {
    try {
      tell("the bridge has died: " + save());
    } catch (const std::exception& error) {
      tell(error.what());
    }
  }
  _exit(0);
}

}  // namespace

Supervisor::Supervisor(const std::function<void()>& power_off, const std::function<std::string()>& save,
                       std::int64_t hang_ns) {
  void* shared = mmap(nullptr, sizeof(Heartbeat), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) fail("no shared memory");
  heartbeat_ = new (shared) Heartbeat;
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) fail("no pipe");
  std::fflush(nullptr);
  pid_ = fork();
  if (pid_ < 0) fail("no process");
  if (pid_ == 0) {
    ::close(ends[1]);
    supervise(ends[0], *heartbeat_, hang_ns, power_off, save);
  }
  ::close(ends[0]);
  pipe_ = ends[1];
}

Supervisor::~Supervisor() {
  // it may have ended already
  std::signal(SIGPIPE, SIG_IGN);
  [[maybe_unused]] const ssize_t n = ::write(pipe_, &kInOrder, 1);
  ::close(pipe_);
  if (!reaped_) {
    kill(pid_, SIGCONT);  // one that was stopped reads that its work is done
    waitpid(pid_, nullptr, 0);
  }
  munmap(heartbeat_, sizeof(Heartbeat));
}

bool Supervisor::alive() {
  int status = 0;
  if (!lost_ && waitpid(pid_, &status, WNOHANG | WUNTRACED) != 0) {
    lost_ = true;
    reaped_ = !WIFSTOPPED(status);
  }
  return !lost_;
}

}  // namespace palp
