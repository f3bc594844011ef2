// The look of matter, as a picture needs it: a few numbers of optics, in SI.
#pragma once

#include <array>

namespace palp {

// A surface with a microfacet highlight (GGX) and Fresnel's reflection, and what light meets below it. The colour
// stands beside it: of what scatters light, of a metal's reflection.
struct Look {
  bool clear = false;                       // one looks through it; else light comes back from just below its surface
  float roughness = 0.5f;                   // of the surface: 0 a mirror .. 1 matt
  float metallic = 0;                       // 0 none .. 1 a metal: it reflects in its colour and scatters nothing
  float refractive_index = 1.5f;            // 1 reflects nothing
  std::array<float, 3> absorption_per_m{};  // of red, green and blue light, by what is clear [1/m]
  float scattering_length = 0;  // how far light comes before it is scattered [m]: haze of what is clear, softness of
                                // what is not
  float grain = 0;              // contrast of a solid's rings, as those of wood: 0 none .. 1
  float foam = 0;               // how white a liquid is that flies apart: 0 stays one surface .. 1 water
  bool operator==(const Look&) const = default;
};

// The ranges of these numbers on the bus and in files; none is negative.
inline constexpr float kMostRefractiveIndex = 5;    // germanium has 4
inline constexpr float kMostAbsorptionPerM = 1e6f;  // metals have 1e8, and are not clear
inline constexpr float kMostScatteringLength = 1e3f;

}  // namespace palp
