// How every program of palp reads its command line. CLI11 takes long to compile: only files that declare options
// include this.
#pragma once

#include <CLI/CLI.hpp>

#include <optional>

#include "config/program.h"
#include "config/version.h"

namespace palp {

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

// Reads the command line into what the app's options name, then runs.
template <class Run>
int run_program(const char* program, CLI::App& app, int argc, const char* const* argv, Run&& run) {
  if (const auto status = read_command_line(app, program, argc, argv)) return *status;
  return run_program(program, run);
}

}  // namespace palp
