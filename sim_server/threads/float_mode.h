// The way that a thread treats subnormal numbers, those between 0 and the least normal one (1.2e-38). Where a hand
// holds still and bodies come to rest, velocities fade through them to zero; an Intel processor needs some 150 cycles
// for each sum or product of one, so that a scene at rest cost three times one that moves.
#pragma once

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace palp {

// Returns how this thread computes, for set_float_mode() in another one.
inline unsigned float_mode() {
#if defined(__SSE2__)
  return _mm_getcsr();
#else
  return 0;
#endif
}

inline void set_float_mode([[maybe_unused]] unsigned mode) {
#if defined(__SSE2__)
  _mm_setcsr(mode);
#endif
}

// While one lives, the thread that made it takes subnormal numbers for zero and makes none. Of no effect but on x86,
// where alone they are known to be slow.
class FlushSubnormals {
 public:
  FlushSubnormals() : before_(float_mode()) { set_float_mode(before_ | kFlush); }
  ~FlushSubnormals() { set_float_mode(before_); }
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

 private:
  static constexpr unsigned kFlush = 0x8040;  // results to zero, operands taken for zero (MXCSR: FTZ, DAZ)
  unsigned before_;
};

}  // namespace palp
