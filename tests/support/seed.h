// The seed of a test of random cases.
#pragma once

#include <cstdlib>
#include <random>
#include <string>

namespace palp::test {

// A seed of its own for each run; PALP_SEED, as a failed run printed it, repeats that run's cases.
inline unsigned drawn_seed() {
  const char* given = std::getenv("PALP_SEED");
  return given != nullptr ? static_cast<unsigned>(std::stoul(given)) : std::random_device{}();
}

}  // namespace palp::test
