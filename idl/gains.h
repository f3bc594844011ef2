// Gains of the virtual coupling (idl/coupling.h): one type for profile, wire, scene file and kernel. It needs no Eigen,
// so that the messages can hold it. Host and device.
#pragma once

namespace palp {

template <class S>
struct Gains {
  S stiffness = 0;          // [N/m]
  S damping = 0;            // [N s/m]
  S angular_stiffness = 0;  // [N m/rad]
  S angular_damping = 0;    // [N m s/rad]
  bool operator==(const Gains&) const = default;

  template <class T>
  constexpr Gains<T> cast() const {
    return {static_cast<T>(stiffness), static_cast<T>(damping), static_cast<T>(angular_stiffness),
            static_cast<T>(angular_damping)};
  }
};

// Everywhere but in the kernels gains are in double precision. The bridge proposes them, the server answers with those
// that it used.
using CouplingGains = Gains<double>;

// A bridge proposes these, and a server allows them, unless a profile or a scene says otherwise.
inline constexpr CouplingGains kDefaultGains{1000, 20, 10, 0.2};

}  // namespace palp
