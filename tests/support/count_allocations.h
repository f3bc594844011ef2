// Counts what the calling thread allocates with new. Link count_allocations.cpp, which replaces the global operators.
#pragma once

#include <cstdint>

namespace palp::test {

void start_counting_allocations();
// How many there were since the start.
std::uint64_t stop_counting_allocations();

}  // namespace palp::test
