// Prints the bill of a scene (solver/bill.h), for people or as JSON.
#pragma once

#include <string>

#include "config/json_file.h"
#include "sim_server/solver/bill.h"

namespace palp {

// Returns the bill as lines for people; what it has nothing of is left out.
std::string text_of(const Bill& bill);

// Returns the bill as JSON. times: with what was measured; else only what follows from the scene and the back end.
Json json_of(const Bill& bill, bool times = true);

// Measures the simulation for a second and prints its bill on standard output: form "text" or "json"; any other is the
// JSON file to write. Throws std::runtime_error when the file cannot be written.
void explain(Simulation& simulation, const std::string& form);

}  // namespace palp
