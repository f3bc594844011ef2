// The line on standard error in which a program says what it does while it loads a scene, once that has taken half a
// second. A terminal has it rewritten, a log gets one every few seconds.
#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdio>

namespace palp {

class LoadingLine {
 public:
  LoadingLine() : terminal_(isatty(STDERR_FILENO) != 0) {}
  ~LoadingLine() {
    if (told_ && terminal_) std::fprintf(stderr, "\r%60s\r", "");
  }
  LoadingLine(const LoadingLine&) = delete;
  LoadingLine& operator=(const LoadingLine&) = delete;

  // Tells what is being done and which share of it is done, 0 to 1, where it is time for that.
  void tell(const char* doing, double share) {
    const double now = std::chrono::duration<double>(Clock::now() - begin_).count();
    if (now < due_) return;
    const char* end = terminal_ ? "" : "\n";
    if (share > 0)
      std::fprintf(stderr, "%sloading, %4.1f s: %s, %2.0f %%%s", terminal_ ? "\r" : "", now, doing, 100 * share, end);
    else
      std::fprintf(stderr, "%sloading, %4.1f s: %s%s%s", terminal_ ? "\r" : "", now, doing, terminal_ ? "      " : "",
                   end);
    told_ = true;
    due_ = now + (terminal_ ? kFirst / 5 : 5.0);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kFirst = 0.5;  // [s]
  Clock::time_point begin_ = Clock::now();
  double due_ = kFirst;  // [s] since the beginning
  bool terminal_;
  bool told_ = false;
};

}  // namespace palp
