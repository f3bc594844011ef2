// The cells of the stability map, by name.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palp::stability {

// Returns the cells of all families: those that CI runs, or all.
std::vector<std::string> listed_cells(bool all);

// Returns the k-th random cell of a seed: one to three modules and a value on each axis, every other one its default.
std::string random_cell(std::uint64_t seed, std::uint64_t k);

}  // namespace palp::stability
