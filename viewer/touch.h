// The words of touch: which particles may touch a tool, and how much of it is touched.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace palp {

// The colour of what is touched where no pressures are shown: one that neither wood nor metal nor food has.
inline constexpr std::array<float, 3> kTouchedColor{1.0f, 0.30f, 0.85f};

struct ParticleRange {
  std::uint32_t first = 0, count = 0;
};

struct Touch {
  double area = 0;                 // [m^2] of its surface
  std::optional<double> pressure;  // [Pa] mean over that; unset: nothing is touched, or no pressure is sent
};

}  // namespace palp
