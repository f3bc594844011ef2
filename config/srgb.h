// The transfer of sRGB (IEC 61966-2-1): numbers as files and screens have them, 0 .. 1, and the light that they stand
// for.
#pragma once

#include <cmath>

namespace palp {

template <class T>
T light_of_srgb(T shown) {
  return shown <= T(0.04045) ? shown / T(12.92) : std::pow((shown + T(0.055)) / T(1.055), T(2.4));
}

template <class T>
T srgb_of_light(T light) {
  return light <= T(0.0031308) ? T(12.92) * light : T(1.055) * std::pow(light, 1 / T(2.4)) - T(0.055);
}

}  // namespace palp
