// The bounds that a run was checked for, and how near it came to each: for summaries and for the last line of a
// program.
#pragma once

#include <string>

#include "config/json_file.h"
#include "sim_server/solver/simulation.h"

namespace palp {

// The worst of all steps of a run.
struct HealthRecord {
  Health worst;  // each figure by itself; cause, doubt and notice: the first of each

  void add(const Health& health);
  // Returns true when no step diverged and nothing makes the answer doubtful.
  bool healthy() const { return worst.ok && worst.doubt.empty(); }
  // Returns the reason why it is not healthy; empty when it is.
  const std::string& trouble() const { return worst.ok ? worst.doubt : worst.cause; }
};

// Returns what was checked, in one line: "finite, speeds to 1.1 m/s of 1.8 expected, ...".
std::string describe(const HealthRecord& record);

// Returns the same for programs: "checked", the line above, and each figure beside it.
Json json_of(const HealthRecord& record);

}  // namespace palp
