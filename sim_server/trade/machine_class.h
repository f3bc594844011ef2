// Which class of machines this one belongs to, and the table that was measured on such a one.
#pragma once

#include <string>
#include <vector>

#include "sim_server/solver/simulation.h"

namespace palp {

// Returns the class of what a back end computes on here: "cpu-2" where this process may use two processors, or the
// GPU's short name, "h200". Automatic: the GPU where there is one for it.
std::string machine_class(Backend backend);

// Returns the short name of a GPU: the words of its name up to the first with a digit, without the maker's and the
// brand's, in small letters: "NVIDIA H100 80GB HBM3" is "h100", "NVIDIA GeForce RTX 4090" is "rtx-4090".
std::string short_gpu_name(const std::string& name);

// Returns that one of some classes that a machine is most like: its own; else of the same kind, among CPUs the one
// whose number of processors has the ratio to its own that is nearest to one; else any. Empty where there is none.
std::string nearest_class(const std::string& machine, const std::vector<std::string>& classes);

// Returns the file of the nearest class's table: in ./config/trade, or else among palp's own. Throws ConfigError when
// there is no table at all.
std::string find_trade_table(const std::string& machine);

}  // namespace palp
