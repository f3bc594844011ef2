#include "haptic_bridge/log/crash_log.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>

#include <unistd.h>

#include "haptic_bridge/log/rerun.h"

namespace palp {

namespace {

constexpr int kDeadly[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
constexpr unsigned kPatienceSeconds = 5;

const FlightLog* g_log = nullptr;
const LoopConfig* g_config = nullptr;
const std::string* g_path = nullptr;
std::atomic<bool> g_dying{false};

void write_and_die(int signal) {
  std::signal(signal, SIG_DFL);
  if (!g_dying.exchange(true)) {
    std::signal(SIGALRM, SIG_DFL);
    sigset_t alarm_only;
    sigemptyset(&alarm_only);
    sigaddset(&alarm_only, SIGALRM);
    pthread_sigmask(SIG_UNBLOCK, &alarm_only, nullptr);
    alarm(kPatienceSeconds);
    try {
      if (g_log) write_log_and_run(*g_log, *g_config, *g_path);
      std::fprintf(stderr, "palp-haptic-bridge: died of signal %d; the flight log was written to %s\n", signal,
                   g_path->c_str());
    } catch (const std::exception& error) {
      std::fprintf(stderr, "palp-haptic-bridge: died of signal %d; %s\n", signal, error.what());
    }
  } else {
    pause();  // another thread is writing
  }
  std::raise(signal);
}

}  // namespace

CrashLog::CrashLog(const FlightLog& log, const LoopConfig& config, const std::string& path) {
  g_log = &log;
  g_config = &config;
  g_path = new std::string(path);
  for (int signal : kDeadly) std::signal(signal, write_and_die);
}

CrashLog::~CrashLog() {
  for (int signal : kDeadly) std::signal(signal, SIG_DFL);
  g_log = nullptr;
  delete g_path;
  g_path = nullptr;
}

}  // namespace palp
