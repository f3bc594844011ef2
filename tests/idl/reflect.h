// Walks the fields of a message without a list of them, so that a field forgotten on the wire cannot be forgotten here
// too.
#pragma once

#include <array>
#include <string>
#include <type_traits>
#include <vector>

namespace palp::test {

struct Anything {
  template <class T>
  operator T() const;
};

template <class T, class... Fields>
consteval std::size_t field_count() {
  if constexpr (requires { T{Fields{}..., Anything{}}; }) {
    return field_count<T, Fields..., Anything>();
  } else {
    return sizeof...(Fields);
  }
}

// Calls f(a.field, b.field) for each field of two objects of one aggregate type.
template <class F, class A, class B>
void for_each_field(F&& f, A& a, B& b) {
  constexpr std::size_t n = field_count<std::remove_const_t<A>>();
// NOLINTBEGIN(bugprone-macro-parentheses): lists of names and calls
#define PALP_FIELDS(count, names_a, names_b, calls) \
  if constexpr (n == count) {                       \
    auto& [PALP_UNPACK names_a] = a;                \
    auto& [PALP_UNPACK names_b] = b;                \
    calls;                                          \
  } else
#define PALP_UNPACK(...) __VA_ARGS__
  PALP_FIELDS(2, (a0, a1), (b0, b1), (f(a0, b0), f(a1, b1)))
  PALP_FIELDS(3, (a0, a1, a2), (b0, b1, b2), (f(a0, b0), f(a1, b1), f(a2, b2)))
  PALP_FIELDS(4, (a0, a1, a2, a3), (b0, b1, b2, b3), (f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3)))
  PALP_FIELDS(5, (a0, a1, a2, a3, a4), (b0, b1, b2, b3, b4), (f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3), f(a4, b4)))
  PALP_FIELDS(7, (a0, a1, a2, a3, a4, a5, a6), (b0, b1, b2, b3, b4, b5, b6),
              (f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3), f(a4, b4), f(a5, b5), f(a6, b6)))
  PALP_FIELDS(8, (a0, a1, a2, a3, a4, a5, a6, a7), (b0, b1, b2, b3, b4, b5, b6, b7),
              (f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3), f(a4, b4), f(a5, b5), f(a6, b6), f(a7, b7)))
  PALP_FIELDS(9, (a0, a1, a2, a3, a4, a5, a6, a7, a8), (b0, b1, b2, b3, b4, b5, b6, b7, b8),
              (f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3), f(a4, b4), f(a5, b5), f(a6, b6), f(a7, b7), f(a8, b8)))
  PALP_FIELDS(
      10, (a0, a1, a2, a3, a4, a5, a6, a7, a8, a9), (b0, b1, b2, b3, b4, b5, b6, b7, b8, b9),
      (f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3), f(a4, b4), f(a5, b5), f(a6, b6), f(a7, b7), f(a8, b8), f(a9, b9)))
  PALP_FIELDS(11, (a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10), (b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10),
              (f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3), f(a4, b4), f(a5, b5), f(a6, b6), f(a7, b7), f(a8, b8),
               f(a9, b9), f(a10, b10)))
  PALP_FIELDS(12, (a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11),
              (b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11),
              (f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3), f(a4, b4), f(a5, b5), f(a6, b6), f(a7, b7), f(a8, b8),
               f(a9, b9), f(a10, b10), f(a11, b11)))
  PALP_FIELDS(14, (a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13),
              (b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11, b12, b13),
              (f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3), f(a4, b4), f(a5, b5), f(a6, b6), f(a7, b7), f(a8, b8),
               f(a9, b9), f(a10, b10), f(a11, b11), f(a12, b12), f(a13, b13)))
  PALP_FIELDS(15, (a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a12, a13, a14),
              (b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11, b12, b13, b14),
              (f(a0, b0), f(a1, b1), f(a2, b2), f(a3, b3), f(a4, b4), f(a5, b5), f(a6, b6), f(a7, b7), f(a8, b8),
               f(a9, b9), f(a10, b10), f(a11, b11), f(a12, b12), f(a13, b13), f(a14, b14)))
  static_assert(n == 2, "a message has a number of fields for which for_each_field has no line: add one");
#undef PALP_UNPACK
#undef PALP_FIELDS
  // NOLINTEND(bugprone-macro-parentheses)
}

// Gives every scalar and string below x a value of its own.
struct Fill {
  int next = 1;

  template <class T>
  void operator()(T& x) {
    if constexpr (std::is_same_v<T, bool>) {
      x = true;
    } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      x = static_cast<T>(next++);
    } else if constexpr (std::is_same_v<T, std::string>) {
      x = "text " + std::to_string(next++);
    } else {
      for_each_field([this](auto& field, auto&) { (*this)(field); }, x, x);
    }
  }
  template <class T, std::size_t n>
  void operator()(std::array<T, n>& x) {
    for (T& element : x) (*this)(element);
  }
  template <class T>
  void operator()(std::vector<T>& x) {
    x.resize(3 + static_cast<std::size_t>(next) % 3);
    for (T& element : x) (*this)(element);
  }
};

// Counts the scalars and strings that differ.
struct Differences {
  int count = 0;

  template <class T>
  void operator()(const T& a, const T& b) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string>) {
      count += a == b ? 0 : 1;
    } else {
      for_each_field([this](const auto& x, const auto& y) { (*this)(x, y); }, a, b);
    }
  }
  template <class T, std::size_t n>
  void operator()(const std::array<T, n>& a, const std::array<T, n>& b) {
    for (std::size_t i = 0; i < n; ++i) (*this)(a[i], b[i]);
  }
  template <class T>
  void operator()(const std::vector<T>& a, const std::vector<T>& b) {
    if (a.size() != b.size()) {
      ++count;
      return;
    }
    for (std::size_t i = 0; i < a.size(); ++i) (*this)(a[i], b[i]);
  }
};

}  // namespace palp::test
