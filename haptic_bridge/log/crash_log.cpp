#include "haptic_bridge/log/crash_log.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "haptic_bridge/log/rerun.h"

namespace palp {

namespace {

constexpr int kDeadly[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
constexpr unsigned kPatienceSeconds = 5;

// Ends of pipes: through the first the thread that dies hands over the signal's number, the second tells it that all is
// written. A handler may write and read them, while it may wait for no lock.
int g_asked[2] = {-1, -1}, g_written[2] = {-1, -1};
std::atomic<bool> g_dying{false};

// Both retry when a signal comes between. Return false when the other end is closed.
bool send(int pipe, int value) {
  ssize_t done = 0;
  do done = write(pipe, &value, sizeof value);
  while (done < 0 && errno == EINTR);
  return done == sizeof value;
}
bool receive(int pipe, int& value) {
  ssize_t done = 0;
  do done = read(pipe, &value, sizeof value);
  while (done < 0 && errno == EINTR);
  return done == sizeof value;
}

void have_it_written_and_die(int signal) {
  std::signal(signal, SIG_DFL);
  if (!g_dying.exchange(true)) {
    std::signal(SIGALRM, SIG_DFL);
    sigset_t alarm_only;
    sigemptyset(&alarm_only);
    sigaddset(&alarm_only, SIGALRM);
    pthread_sigmask(SIG_UNBLOCK, &alarm_only, nullptr);
    alarm(kPatienceSeconds);
    int done = 0;
    if (send(g_asked[1], signal)) receive(g_written[0], done);
  } else {
    pause();  // another thread's death is being written
  }
  std::raise(signal);
}

void write_when_asked(const FlightLog& log, const LoopConfig& config, const std::string& path) {
  int signal = 0;
  if (!receive(g_asked[0], signal)) return;
  char words[1000];
  int length = 0;
  try {
    write_log_and_run(log, config, path);
    length =
        std::snprintf(words, sizeof words, "palp-haptic-bridge: died of signal %d; the flight log was written to %s\n",
                      signal, path.c_str());
  } catch (const std::exception& error) {
    length = std::snprintf(words, sizeof words, "palp-haptic-bridge: died of signal %d; %s\n", signal, error.what());
  }
  const auto size = static_cast<std::size_t>(std::min(length, static_cast<int>(sizeof words) - 1));
  const ssize_t told = write(STDERR_FILENO, words, size);  // by no stream: the thread that dies may hold its lock
  send(g_written[1], told < 0 ? errno : 0);
}

void open_pipe(int (&ends)[2]) {
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "a pipe of the crash log");
}

}  // namespace

CrashLog::CrashLog(const FlightLog& log, const LoopConfig& config, const std::string& path) {
  open_pipe(g_asked);
  open_pipe(g_written);
  // signals that are meant for the process go to other threads
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  writer_ = std::thread([&log, &config, path] { write_when_asked(log, config, path); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  for (int signal : kDeadly) std::signal(signal, have_it_written_and_die);
}

CrashLog::~CrashLog() {
  for (int signal : kDeadly) std::signal(signal, SIG_DFL);
  close(g_asked[1]);  // lets the thread go
  writer_.join();
  close(g_asked[0]);
  for (const int end : g_written) close(end);
}

}  // namespace palp
