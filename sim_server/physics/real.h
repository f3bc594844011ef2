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
// The attribute of a lambda that is called for each pair of neighbours: a call would cost more than its body.
#define PALP_INLINE __attribute__((always_inline))

namespace palp {

#ifdef PALP_DOUBLE
using real = double;
#else
using real = float;
#endif

// Small types over a scalar S, for functions that the host calls in double, too.
template <class S>
using Vec3Of = Eigen::Matrix<S, 3, 1>;
template <class S>
using Mat3Of = Eigen::Matrix<S, 3, 3>;

using Vec3 = Vec3Of<real>;
using Mat3 = Mat3Of<real>;
using Quat = Eigen::Quaternion<real>;

template <class S>
inline constexpr S kPiOf = S(3.14159265358979323846);
inline constexpr real kPi = kPiOf<real>;

// Returns the smaller one, and b where a is not a number. std::min is no device function.
template <class S>
PALP_HD inline S min(S a, S b) {
  return a < b ? a : b;
}

// Returns a where a condition holds, else b.
template <class S>
PALP_HD inline S select(bool condition, S a, S b) {
  return condition ? a : b;
}
// Returns x, and 0 where it is below.
template <class S>
PALP_HD inline S positive(const S& x) {
  return select(x > S(0), x, S(0));
}

// Four scalars that are loaded and stored at once.
template <class S>
struct alignas(4 * sizeof(S)) PackedOf {
  S x, y, z, w;
  PALP_HD Vec3Of<S> xyz() const { return {x, y, z}; }
};
using Packed = PackedOf<real>;

// Returns all four of index j, read by one load, which a GPU's compiler would otherwise split where it can. Nothing may
// write them while the kernel runs.
template <class S = real>
PALP_HD inline PackedOf<S> fetch(const Packed* p, std::uint32_t j) {
#ifdef __CUDA_ARCH__
  const float4 v = __ldg(reinterpret_cast<const float4*>(p + j));
  return {v.x, v.y, v.z, v.w};
#else
  return {p[j].x, p[j].y, p[j].z, p[j].w};
#endif
}
// Returns the index of one that stands for all.
PALP_HD inline std::uint32_t first_of(std::uint32_t j) { return j; }
// Returns the last of the four.
template <class S = real>
PALP_HD inline S fetch_w(const Packed* p, std::uint32_t j) {
  return p[j].w;
}

// Sets a flag that several threads may set at once, and nobody reads until they have ended.
PALP_HD inline void raise_flag(std::uint32_t* flag) {
#ifdef __CUDA_ARCH__
  *flag = 1;
#else
  __atomic_store_n(flag, 1u, __ATOMIC_RELAXED);
#endif
}

PALP_HD inline Packed pack(const Vec3& v, real w) { return {v.x(), v.y(), v.z(), w}; }

// Returns m v. Eigen leaves this product to a function call where it stands in a larger expression.
PALP_HD inline Vec3 mat_vec(const Mat3& m, const Vec3& v) {
  return {m(0, 0) * v.x() + m(0, 1) * v.y() + m(0, 2) * v.z(), m(1, 0) * v.x() + m(1, 1) * v.y() + m(1, 2) * v.z(),
          m(2, 0) * v.x() + m(2, 1) * v.y() + m(2, 2) * v.z()};
}

}  // namespace palp
