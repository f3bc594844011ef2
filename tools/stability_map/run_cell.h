// One cell of the stability map: its scene is made, run and judged.
#pragma once

#include <string>

#include "sim_server/solver/simulation.h"

namespace palp::stability {

enum class End { bounded, refused, fault, too_long };

struct CellResult {
  std::string cell;
  End end = End::fault;
  std::string cause;  // refused: the kind of cause; fault: one sentence
  std::string text;   // what people were told, where anything was
  std::string plan;   // the line of numerics that programs print
  std::size_t particles = 0;
  int steps = 0, sub_steps = 0;
  double time = 0;                            // simulated [s]
  double energy = 0, momentum = 0, heat = 0;  // over what is allowed (books.h)
  double seconds = 0;                         // that it took
};

struct RunLimits {
  double work = 1;    // of a cell over the default, about half a second on one core
  double most = 100;  // a cell that needs more work than so many times the default for two steps is too long
};

// Runs the cell of this name (setup.h). Its files lie in folder under `file`, and stay there. Never throws for what a
// cell does; throws ConfigError for a name that is none.
CellResult run_cell(const std::string& cell, Backend backend, const RunLimits& limits, const std::string& folder,
                    const std::string& file);

const char* to_string(End end);

}  // namespace palp::stability
