#include "tests/support/kernels.h"

#include <cmath>

namespace palp::test {

using Eigen::Vector3d;

// The quintic spline from 2.5 spacings on (Morris 1996, piece by piece; q = r / h), Wendland C2 below.
double fluid_kernel(double r, double H, double spacing) {
  if (H < 2.5 * spacing) return wendland(r, H);
  const double h = H / 3, q = r / h, s = 1 / (120 * M_PI * h * h * h);
  if (q < 1) return s * (std::pow(3 - q, 5) - 6 * std::pow(2 - q, 5) + 15 * std::pow(1 - q, 5));
  if (q < 2) return s * (std::pow(3 - q, 5) - 6 * std::pow(2 - q, 5));
  return q < 3 ? s * std::pow(3 - q, 5) : 0;
}
Vector3d fluid_gradient(const Vector3d& x, double H, double spacing) {
  if (H < 2.5 * spacing) return wendland_gradient(x, H);
  const double r = x.norm();
  if (r >= H || r == 0) return Vector3d::Zero();
  const double h = H / 3, q = r / h, s = -5 / (120 * M_PI * h * h * h);
  double sum = std::pow(3 - q, 4);
  if (q < 2) sum -= 6 * std::pow(2 - q, 4);
  if (q < 1) sum += 15 * std::pow(1 - q, 4);
  return s * sum / h * x / r;
}

double wendland(double r, double H) {
  const double q = r / H;
  return q < 1 ? 21 / (2 * M_PI * H * H * H) * std::pow(1 - q, 4) * (4 * q + 1) : 0;
}
Vector3d wendland_gradient(const Vector3d& x, double H) {
  const double r = x.norm(), q = r / H;
  if (q >= 1 || r == 0) return Vector3d::Zero();
  return 21 / (2 * M_PI * H * H * H) * (-20 * q * std::pow(1 - q, 3)) / H * x / r;
}
double poly6(double r, double H) { return r < H ? 315 / (64 * M_PI * std::pow(H, 9)) * std::pow(H * H - r * r, 3) : 0; }
Vector3d poly6_gradient(const Vector3d& x, double H) {
  const double r = x.norm();
  if (r >= H) return Vector3d::Zero();
  return -945 / (32 * M_PI * std::pow(H, 9)) * std::pow(H * H - r * r, 2) * x;
}
double viscosity_laplacian(double r, double H) { return r < H ? 45 / (M_PI * std::pow(H, 6)) * (H - r) : 0; }

}  // namespace palp::test
