// Several neighbours of a particle at a time: a vector register as a scalar of the physics. For the host alone; a GPU
// has a thread for each neighbour.
#pragma once

#include <bit>
#include <cstring>
#include <experimental/simd>

#include "sim_server/physics/real.h"

namespace palp {

#ifdef __AVX__
inline constexpr int kLanes = 32 / sizeof(real);
#else
inline constexpr int kLanes = 16 / sizeof(real);
#endif

// kLanes scalars. It is a type of ours, so that functions below are found where a template asks for them.
struct Lanes {
  using Vector = std::experimental::simd<real, std::experimental::simd_abi::deduce_t<real, kLanes>>;
  using Mask = Vector::mask_type;
  Vector v;
  Lanes() = default;
  Lanes(real all) : v(all) {}  // NOLINT(google-explicit-constructor): a real is a scalar for any formula
  explicit Lanes(const Vector& of) : v(of) {}

  friend Lanes operator-(const Lanes& a) { return Lanes(-a.v); }
  friend Lanes operator+(const Lanes& a, const Lanes& b) { return Lanes(a.v + b.v); }
  friend Lanes operator-(const Lanes& a, const Lanes& b) { return Lanes(a.v - b.v); }
  friend Lanes operator*(const Lanes& a, const Lanes& b) { return Lanes(a.v * b.v); }
  friend Lanes operator/(const Lanes& a, const Lanes& b) { return Lanes(a.v / b.v); }
  Lanes& operator+=(const Lanes& b) { return *this = *this + b; }
  Lanes& operator-=(const Lanes& b) { return *this = *this - b; }
  Lanes& operator*=(const Lanes& b) { return *this = *this * b; }
  Lanes& operator/=(const Lanes& b) { return *this = *this / b; }
  friend Mask operator<(const Lanes& a, const Lanes& b) { return a.v < b.v; }
  friend Mask operator>(const Lanes& a, const Lanes& b) { return a.v > b.v; }
};

inline Lanes sqrt(const Lanes& a) { return Lanes(std::experimental::sqrt(a.v)); }
inline Lanes abs(const Lanes& a) { return Lanes(std::experimental::abs(a.v)); }
inline Lanes select(const Lanes::Mask& where, const Lanes& a, const Lanes& b) {
  Lanes out = b;
  std::experimental::where(where, out.v) = a.v;
  return out;
}
inline Lanes min(const Lanes& a, const Lanes& b) { return select(a < b, a, b); }
// Returns the sum over all lanes, in a fixed order.
inline real sum(const Lanes& a) { return std::experimental::reduce(a.v); }

// Returns 0, 1, 2, ...
inline Lanes lane_numbers() {
  return Lanes(Lanes::Vector([](int k) { return static_cast<real>(k); }));
}

// The indices of kLanes particles, which are alike: the first stands for what they have in common.
struct LaneIndex {
  std::uint32_t of[kLanes];
};

inline std::uint32_t first_of(const LaneIndex& j) { return j.of[0]; }

// Returns the four scalars of each particle: loaded four at once, and turned.
template <int kOf>
[[gnu::always_inline]] inline PackedOf<Lanes> turned(const Packed* p, const LaneIndex& j) {
  using Four [[gnu::vector_size(4 * sizeof(real))]] = real;
  const auto four = [&](int k) {
    Four out;
    std::memcpy(&out, p + j.of[k], sizeof(out));
    return out;
  };
  const auto lanes = [](const auto& v) { return Lanes(std::bit_cast<Lanes::Vector>(v)); };
  if constexpr (kOf == 8) {
    const auto pair = [&](int k) { return __builtin_shufflevector(four(k), four(k + 4), 0, 1, 2, 3, 4, 5, 6, 7); };
    const auto low = [](const auto& a, const auto& b) {
      return __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
    };
    const auto high = [](const auto& a, const auto& b) {
      return __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
    };
    const auto a = pair(0), b = pair(1), c = pair(2), d = pair(3);
    const auto ab_xy = low(a, b), cd_xy = low(c, d), ab_zw = high(a, b), cd_zw = high(c, d);
    const auto first = [&](const auto& ab, const auto& cd) {
      return lanes(__builtin_shufflevector(ab, cd, 0, 1, 8, 9, 4, 5, 12, 13));
    };
    const auto second = [&](const auto& ab, const auto& cd) {
      return lanes(__builtin_shufflevector(ab, cd, 2, 3, 10, 11, 6, 7, 14, 15));
    };
    return {first(ab_xy, cd_xy), second(ab_xy, cd_xy), first(ab_zw, cd_zw), second(ab_zw, cd_zw)};
  } else {
    const auto low = [](const Four& a, const Four& b) { return __builtin_shufflevector(a, b, 0, 4, 1, 5); };
    const auto high = [](const Four& a, const Four& b) { return __builtin_shufflevector(a, b, 2, 6, 3, 7); };
    const Four a = four(0), b = four(1), c = four(2), d = four(3);
    const Four ab_xy = low(a, b), cd_xy = low(c, d), ab_zw = high(a, b), cd_zw = high(c, d);
    const auto first = [&](const Four& ab, const Four& cd) {
      return lanes(__builtin_shufflevector(ab, cd, 0, 1, 4, 5));
    };
    const auto second = [&](const Four& ab, const Four& cd) {
      return lanes(__builtin_shufflevector(ab, cd, 2, 3, 6, 7));
    };
    return {first(ab_xy, cd_xy), second(ab_xy, cd_xy), first(ab_zw, cd_zw), second(ab_zw, cd_zw)};
  }
}

// Returns the four scalars of each particle.
template <class S, int kOf = kLanes>
[[gnu::always_inline]] inline PackedOf<S> fetch(const Packed* p, const LaneIndex& j) {
  static_assert(kOf == 8 || kOf == 4 || kOf == 2);
  if constexpr (kOf == 2) {
    const auto all = [&](real Packed::*of) { return Lanes(Lanes::Vector([&](auto k) { return p[j.of[k]].*of; })); };
    return {all(&Packed::x), all(&Packed::y), all(&Packed::z), all(&Packed::w)};
  } else {
    return turned<kOf>(p, j);
  }
}

// Returns the last of the four scalars of each particle.
template <class S>
[[gnu::always_inline]] inline S fetch_w(const Packed* p, const LaneIndex& j) {
  return Lanes(Lanes::Vector([&](auto k) { return p[j.of[k]].w; }));
}

}  // namespace palp

template <>
struct Eigen::NumTraits<palp::Lanes> : Eigen::GenericNumTraits<palp::Lanes> {
  using Real = palp::Lanes;
  using NonInteger = palp::Lanes;
  using Nested = palp::Lanes;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 1,
    AddCost = 1,
    MulCost = 1
  };
};

// Lanes are aligned by themselves, to more than Eigen aligns to here.
template <int kSize>
struct Eigen::internal::compute_default_alignment<palp::Lanes, kSize> {
  enum { value = 0 };
};
