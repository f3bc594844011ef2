#include "sim_server/solver/cylinder_profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim_server/physics/smoothing.h"

namespace palp {
namespace {

constexpr int kRings = 400;  // of the kernel in the plane across the axis

// The kernel and its F, integrated along the axis, at the middle of each ring about a particle.
struct Rings {
  std::vector<double> q, W, F;
  double width;

  explicit Rings(const FluidKernelOf<double>& kernel) : width(kernel.support / kRings) {
    constexpr int kParts = 200;
    const double support = kernel.support;
    for (int k = 0; k < kRings; ++k) {
      const double at = (k + 0.5) * width, half = std::sqrt(support * support - at * at), part = half / kParts;
      double w = 0, f = 0;
      for (int m = 0; m < kParts; ++m) {
        const double r = std::hypot(at, (m + 0.5) * part);
        w += 2 * part * kernel.W(r);
        f += 2 * part * kernel.F(r);
      }
      q.push_back(at);
      W.push_back(w);
      F.push_back(f);
    }
  }
};

// Returns half the angle of the ring of radius q that lies in the disc, whose centre is at the distance r.
double half_angle(double q, double r, double radius) {
  if (q <= radius - r) return std::numbers::pi;
  if (q >= radius + r || q <= r - radius) return 0;
  return std::acos(std::clamp((q * q + r * r - radius * radius) / (2 * q * r), -1.0, 1.0));
}

}  // namespace

std::vector<Packed> cylinder_profile(double radius, const FluidKernelOf<double>& kernel) {
  const Rings ring(kernel);
  const double support = kernel.support;
  std::vector<Packed> out;
  for (int node = 0; node <= kProfileParts; ++node) {
    const double r = (radius + support) * node / kProfileParts;
    double share = 0, slope = 0, along = 0, around = 0;
    for (int k = 0; k < kRings; ++k) {
      const double q = ring.q[k], half = half_angle(q, r, radius), s = std::sin(half), c = std::cos(half);
      share += 2 * half * q * ring.W[k] * ring.width;
      slope += 2 * s * q * q * ring.F[k] * ring.width;
      along += (half + s * c) * q * q * q * ring.F[k] * ring.width;
      around += (half - s * c) * q * q * q * ring.F[k] * ring.width;
    }
    out.push_back(
        {static_cast<real>(share), static_cast<real>(slope), static_cast<real>(along), static_cast<real>(around)});
  }
  return out;
}

}  // namespace palp
