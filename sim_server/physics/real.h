// The scalar and the small fixed-size types of the physics, on host and device.
// Nothing in this folder includes anything of ours outside it.
#pragma once

#include <cstdint>

#include <Eigen/Geometry>

#if defined(__CUDACC__) && !defined(PALP_HD)
#define PALP_HD __host__ __device__
#elif !defined(PALP_HD)
#define PALP_HD
#endif

namespace palp {

#ifdef PALP_DOUBLE
using real = double;
#else
using real = float;
#endif

using Vec3 = Eigen::Matrix<real, 3, 1>;
using Mat3 = Eigen::Matrix<real, 3, 3>;
using Quat = Eigen::Quaternion<real>;

inline constexpr real kPi = real(3.14159265358979323846);

// Four scalars that are loaded and stored at once.
struct alignas(4 * sizeof(real)) Packed {
  real x, y, z, w;
  PALP_HD Vec3 xyz() const { return {x, y, z}; }
};

// All four in one load, which a GPU's compiler would otherwise split where it can. Nothing may write them meanwhile.
PALP_HD inline Packed fetch(const Packed* p) {
#ifdef __CUDA_ARCH__
  const float4 v = __ldg(reinterpret_cast<const float4*>(p));
  return {v.x, v.y, v.z, v.w};
#else
  return *p;
#endif
}

PALP_HD inline Packed pack(const Vec3& v, real w) { return {v.x(), v.y(), v.z(), w}; }

// m v, which Eigen leaves to a function call where it stands in a larger expression.
PALP_HD inline Vec3 times(const Mat3& m, const Vec3& v) {
  return {m(0, 0) * v.x() + m(0, 1) * v.y() + m(0, 2) * v.z(), m(1, 0) * v.x() + m(1, 1) * v.y() + m(1, 2) * v.z(),
          m(2, 0) * v.x() + m(2, 1) * v.y() + m(2, 2) * v.z()};
}

}  // namespace palp
