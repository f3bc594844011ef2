#include "tests/support/kernels.h"

#include <cmath>

namespace palp::test {

using Eigen::Vector3d;

namespace {

// A spline of order n (Morris 1996), h times (n + 1) / 2 being its support radius: the sum of c_k (k - q)^power over
// those k for which it is above 0.
double spline_sum(double q, int n, int power) {
  double sum = 0, c = 1;
  for (int j = 0; j <= 2; ++j) {
    const double x = 0.5 * (n + 1) - j - q;
    if (x > 0) sum += c * std::pow(x, power);
    c *= -(n + 1.0 - j) / (j + 1);
  }
  return sum;
}

int spline_order(double H, double spacing) { return H < 2.78 * spacing ? 4 : 5; }

double spline_scale(int n, double h) { return 1 / ((n == 4 ? 20 : 120) * M_PI * h * h * h); }

}  // namespace

double fluid_kernel(double r, double H, double spacing) {
  if (H < 2.5 * spacing) return wendland(r, H);
  const int n = spline_order(H, spacing);
  const double h = 2 * H / (n + 1);
  return spline_scale(n, h) * spline_sum(r / h, n, n);
}
Vector3d fluid_gradient(const Vector3d& x, double H, double spacing) {
  if (H < 2.5 * spacing) return wendland_gradient(x, H);
  const double r = x.norm();
  if (r >= H || r == 0) return Vector3d::Zero();
  const int n = spline_order(H, spacing);
  const double h = 2 * H / (n + 1);
  return -n * spline_scale(n, h) * spline_sum(r / h, n, n - 1) / h * x / r;
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
double lattice_cover(double H) {
  double sum = 0;
  for (int x = -5; x <= 5; ++x)
    for (int y = -5; y <= 5; ++y)
      for (int z = -5; z <= 5; ++z) sum += fluid_kernel(Vector3d(x, y, z).norm(), H, 1);
  return sum;
}

}  // namespace palp::test
