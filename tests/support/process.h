// Programs under test: each is started with its output caught, watched with a time limit, and never left behind.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/support/files.h"

namespace palp::test {

// A program that runs beside the test. It is killed with the object if it still runs by then.
class ChildProcess {
 public:
  // output: the file that stdout and stderr go to. A program that is named without a path is looked for in PATH.
  ChildProcess(std::vector<std::string> command, std::string output) : output_(std::move(output)) {
    int input[2];
    if (pipe2(input, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    input_ = input[1];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input[0], STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    std::vector<char*> arguments;
    arguments.reserve(command.size() + 1);
    for (std::string& word : command) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int error = posix_spawnp(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(input[0]);
    if (error != 0) {
      close(input_);
      throw std::runtime_error("cannot start " + command[0]);
    }
  }
  ~ChildProcess() {
    if (!status_) end_by_force();
    close(input_);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  pid_t pid() const { return pid_; }
  void send_signal(int number) const {
    if (!status_) kill(pid_, number);  // its number may be another's once it was waited for
  }
  void type(const std::string& text) const {
    if (::write(input_, text.data(), text.size()) < 0) throw std::runtime_error("the program reads no more");
  }

  // Returns the exit status; 128 + n when signal n ended it; -1 when the time ran out (it is killed then).
  int wait(std::chrono::milliseconds limit = std::chrono::seconds(30)) {
    const auto end = std::chrono::steady_clock::now() + limit;
    while (!status_) {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) != 0) {
        status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      } else if (std::chrono::steady_clock::now() > end) {
        end_by_force();
      } else {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
    }
    return *status_;
  }
  int stop(int number = SIGTERM) {
    send_signal(number);
    return wait();
  }
  std::string output() const { return text_of(output_); }

 private:
  void end_by_force() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    status_ = -1;
  }

  std::string output_;
  pid_t pid_ = -1;
  int input_ = -1;
  std::optional<int> status_;  // once it has ended
};

// How a program ended.
struct Outcome {
  int status = -1;     // as ChildProcess::wait returns it
  std::string output;  // stdout and stderr
};

// Runs a program to its end, or until the time is up.
inline Outcome run_program(std::vector<std::string> command,
                           std::chrono::milliseconds limit = std::chrono::seconds(60)) {
  const ScratchFolder folder;
  ChildProcess program(std::move(command), folder / "output.txt");
  const int status = program.wait(limit);
  return {status, program.output()};
}

}  // namespace palp::test
