// How every program of palp reads its command line and how it ends. Exit status: 0 done, 1 the run failed, 2 bad input;
// a program's main file says where it has others. Header only: libraries do not need CLI11.
#pragma once

#include <CLI/CLI.hpp>

#include <cstdio>
#include <exception>
#include <optional>
#include <string>

#include "config/error.h"
#include "config/version.h"

namespace palp {

inline constexpr int kExitFailed = 1, kExitBadInput = 2;

// Reads the command line; adds --version to what the program declared. Returns the exit status where the program is to
// end here: help or version was printed, or one sentence about what cannot be used. None: go on.
inline std::optional<int> read_command_line(CLI::App& app, const char* program, int argc, const char* const* argv) {
  app.name(program);
  app.set_version_flag("--version", version_of(program));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kExitBadInput;
  }
  return std::nullopt;
}

// Runs what a program does after its command line was read and returns its exit status; what is thrown is printed, one
// line a fault.
template <class Run>
int run_program(const char* program, Run&& run) {
  try {
    return run();
  } catch (const ConfigError& error) {
    for (const std::string& fault : error.faults()) std::fprintf(stderr, "%s: %s\n", program, fault.c_str());
    return kExitBadInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return kExitFailed;
  }
}

// Does both: reads the command line into what app's options name, then runs.
template <class Run>
int run_program(const char* program, CLI::App& app, int argc, const char* const* argv, Run&& run) {
  if (const auto status = read_command_line(app, program, argc, argv)) return *status;
  return run_program(program, run);
}

}  // namespace palp
