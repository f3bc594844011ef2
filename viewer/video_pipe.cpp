#include "viewer/video_pipe.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

extern char** environ;

namespace palp {
namespace {

constexpr int kWriteTimeoutMs = 30'000;  // ffmpeg has taken ten seconds to start on a machine that was busy
constexpr std::chrono::seconds kCloseTimeout{30};

// Fails early and with a clear sentence, where ffmpeg would say it later in many.
void check_writable(const std::string& file) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (fd < 0) throw std::runtime_error(fmt::format("cannot write the video {}: {}", file, std::strerror(errno)));
  ::close(fd);
}

pid_t spawn_ffmpeg(std::vector<std::string> arguments, int input) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  // a process group of its own: Ctrl-C in the terminal stops the viewer, which then closes the video in order
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t child = -1;
  const int error = posix_spawnp(&child, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error(fmt::format("cannot start ffmpeg for the video: {}", std::strerror(error)));
  return child;
}

}  // namespace

VideoPipe::VideoPipe(const std::string& file, int width, int height, double rate_hz)
    : file_(file), width_(width), height_(height) {
  if (width < 2 || height < 2) throw std::runtime_error("a video needs pictures of at least 2x2 pixels");
  check_writable(file);
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("cannot make a pipe for the video");
  // without a reader a write must fail, not end the process
  signal(SIGPIPE, SIG_IGN);
  try {
    // H.264 in 4:2:0 needs even sizes
    child_ = spawn_ffmpeg({"ffmpeg",       "-nostdin",
                           "-hide_banner", "-loglevel",
                           "error",        "-y",
                           "-f",           "rawvideo",
                           "-pix_fmt",     "rgb24",
                           "-s",           fmt::format("{}x{}", width, height),
                           "-r",           fmt::format("{}", rate_hz),
                           "-i",           "pipe:0",
                           "-vf",          "vflip,crop=trunc(iw/2)*2:trunc(ih/2)*2",
                           "-c:v",         "libx264",
                           "-preset",      "veryfast",
                           "-crf",         "20",
                           "-threads",     "1",
                           "-pix_fmt",     "yuv420p",
                           "-movflags",    "+faststart",
                           "file:" + file},
                          ends[0]);
  } catch (...) {
    ::close(ends[0]);
    ::close(ends[1]);
    throw;
  }
  ::close(ends[0]);
  pipe_ = ends[1];
  fcntl(pipe_, F_SETFL, O_NONBLOCK);
}

VideoPipe::~VideoPipe() { close(); }

bool VideoPipe::fail(const std::string& what) {
  if (ok_) spdlog::error("the video {} is not whole: {}", file_, what);
  ok_ = false;
  return false;
}

bool VideoPipe::write(const std::vector<std::uint8_t>& rgb) {
  if (!ok_ || pipe_ < 0) return false;
  std::size_t done = 0;
  while (done < rgb.size()) {
    const ssize_t n = ::write(pipe_, rgb.data() + done, rgb.size() - done);
    if (n > 0) {
      done += static_cast<std::size_t>(n);
      continue;
    }
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno != EAGAIN) return fail("ffmpeg has ended");
    pollfd wait{pipe_, POLLOUT, 0};
    if (poll(&wait, 1, kWriteTimeoutMs) == 0) return fail("ffmpeg takes no more pictures");
  }
  return true;
}

bool VideoPipe::close() {
  if (pipe_ < 0) return ok_;
  ::close(pipe_);
  pipe_ = -1;
  int status = 0;
  const auto until = std::chrono::steady_clock::now() + kCloseTimeout;
  for (;;) {
    const pid_t ended = waitpid(child_, &status, WNOHANG);
    if (ended == child_) break;
    if (ended < 0 && errno != EINTR) return fail("ffmpeg was lost");
    if (std::chrono::steady_clock::now() > until) {
      ::kill(child_, SIGKILL);
      waitpid(child_, &status, 0);
      return fail("ffmpeg did not finish");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return fail("ffmpeg reported an error");
  if (ok_) spdlog::info("wrote {}", file_);
  return ok_;
}

}  // namespace palp
