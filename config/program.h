// How every program of palp ends. Exit status: 0 done, 1 the run failed, 2 bad input; a program's main file says where
// it has others.
#pragma once

#include <cstdio>
#include <exception>
#include <optional>
#include <string>

#include "config/error.h"

namespace palp {

inline constexpr int kExitFailed = 1, kExitBadInput = 2;

// The options of a command line. Without them the program is to end with the exit status: 0 where help or the version
// was printed, else a fault was.
template <class Options>
struct Parsed {
  std::optional<Options> options;
  int exit_status = 0;
};

// Runs what a program does and returns its exit status; what is thrown is printed, one line a fault.
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

}  // namespace palp
