// The smoothing kernels' defining properties (paper Eq. 1).
#include <functional>

#include <gtest/gtest.h>

#include "sim_server/physics/smoothing.h"
#include "tests/support/equations.h"
#include "tests/support/tolerance.h"

namespace palp::test::smoothing_test {
namespace {

constexpr double kSupport = 0.7;

struct KernelCase {
  const char* name;
  std::function<double(double)> value;  // W(r), or a Laplacian whose integral is 1
};

std::vector<KernelCase> kernels() {
  const auto wendland_c2 = WendlandC2::with_support(real(kSupport));
  const auto mueller = Mueller::with_support(real(kSupport));
  return {{"Wendland C2", [=](double r) { return wendland_c2.W(real(r)); }},
          {"poly6", [=](double r) { return mueller.poly6(real(r * r)); }},
          // the integral of Mueller's Laplacian is 1 as well: 45/(pi H^6) 4 pi int (H - r) r^2 dr = 180 H^4 / (12 H^6)
          {"viscosity Laplacian times H^2 / 15",
           [=](double r) { return mueller.laplacian(real(r)) * kSupport * kSupport / 15; }},
          {"slope of poly6", [=](double r) {
             double w = 0;  // W(r) = int_r^H F(s) s ds
             constexpr int n = 200;
             const double step = (kSupport - r) / n;
             for (int k = 0; k < n; ++k) {
               const double s = r + (k + 0.5) * step;
               w += mueller.poly6_F(real(s * s)) * s * step;
             }
             return w;
           }}};
}

TEST(Kernels, IntegrateToOne) {
  for (const KernelCase& kernel : kernels()) {
    constexpr int n = 4000;
    double sum = 0;
    for (int k = 0; k < n; ++k) {
      const double r = (k + 0.5) * kSupport / n;
      sum += 4 * M_PI * r * r * kernel.value(r) * kSupport / n;
    }
    const Tolerance tolerance = kernel.name[0] == 's' ? tol::kKernelFromSlope : tol::kKernelIntegral;
    EXPECT_TRUE(within(sum - 1, tolerance)) << kernel.name;
  }
}

TEST(Kernels, AreNonNegativeAndEndAtTheSupport) {
  for (const KernelCase& kernel : kernels()) {
    double before = 1e300;
    for (double r = 0.001; r < kSupport; r += 0.001) {
      const double value = kernel.value(r);
      EXPECT_GE(value, 0) << kernel.name << " at " << r;
      EXPECT_LE(value, before) << kernel.name << " grows at " << r;
      before = value;
    }
    EXPECT_EQ(kernel.value(kSupport), 0) << kernel.name;
    if (kernel.name[0] != 's') {
      EXPECT_EQ(kernel.value(1.01 * kSupport), 0) << kernel.name;
    }
  }
}

TEST(Kernels, SlopeIsTheDerivativeOfTheValue) {
  const auto kernel = WendlandC2::with_support(real(kSupport));
  const double e = sizeof(real) == sizeof(float) ? 2e-3 : 1e-5;
  for (double r = 0.01; r < kSupport - e; r += 0.01) {
    const double slope = (kernel.W(real(r + e)) - kernel.W(real(r - e))) / (2 * e);
    EXPECT_TRUE(within((kernel.F(real(r)) + slope / r) / kernel.F(0), tol::kKernelSlope)) << "at r = " << r;
  }
}

TEST(Kernels, AgreeWithTheTextbook) {
  const auto kernel = WendlandC2::with_support(real(kSupport));
  const auto mueller = Mueller::with_support(real(kSupport));
  for (double r = 0.01; r < kSupport; r += 0.01) {
    const Eigen::Vector3d x(r, 0, 0);
    EXPECT_TRUE(within(kernel.W(real(r)) / wendland(0, kSupport) - wendland(r, kSupport) / wendland(0, kSupport),
                       tol::kOneStep));
    EXPECT_TRUE(within((kernel.F(real(r)) * r + wendland_gradient(x, kSupport).x()) / kernel.F(0), tol::kOneStep));
    EXPECT_TRUE(within((mueller.poly6_F(real(r * r)) * r + poly6_gradient(x, kSupport).x()) / mueller.poly6_F(0),
                       tol::kOneStep));
  }
}

// A kernel that is smooth at the origin needs no unit vector.
TEST(Kernels, AreFiniteForCoincidentParticles) {
  EXPECT_GT(WendlandC2::with_support(1).F(0), 0);
  EXPECT_GT(Mueller::with_support(1).poly6_F(0), 0);
}

struct LatticeSums {
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

LatticeSums lattice_sums(double ratio, const Eigen::Vector3d& at, bool mueller) {
  const auto wendland_c2 = WendlandC2::with_support(real(ratio));
  const auto paper = Mueller::with_support(real(ratio));
  LatticeSums s;
  for (int k = -5; k <= 5; ++k)
    for (int j = -5; j <= 5; ++j)
      for (int i = -5; i <= 5; ++i) {
        const Eigen::Vector3d x = at - Eigen::Vector3d(i, j, k);
        const double r = x.norm();
        s.value += mueller ? paper.poly6(real(r * r)) : wendland_c2.W(real(r));
        s.gradient -= (mueller ? paper.poly6_F(real(r * r)) : wendland_c2.F(real(r))) * x;
      }
  return s;
}

// Sums of the kernels over a lattice, at the support radii in use. The bounds are those measured: at H = 2 dx the
// sums are a few per cent off, which a scheme that integrates the density does not feel and one that sums it does.
TEST(Kernels, SumToOneOnALattice) {
  const struct {
    double ratio;
    bool mueller;
    double value_bound, gradient_bound;
  } cases[] = {{2.0, false, 0.10, 0.15}, {3.0, false, 0.02, 0.02}, {2.0, true, 0.03, 0.5}, {3.0, true, 0.01, 0.3}};
  for (const auto& c : cases) {
    SCOPED_TRACE("H = " + std::to_string(c.ratio) + (c.mueller ? " dx, Mueller" : " dx, Wendland"));
    const LatticeSums at_rest = lattice_sums(c.ratio, Eigen::Vector3d::Zero(), c.mueller);
    EXPECT_LT(at_rest.gradient.norm(), 1e-5);
    EXPECT_NEAR(at_rest.value, 1, c.value_bound);
    double gradient = 0;
    for (double x = 0; x < 1; x += 0.125)
      for (double y = 0; y < 1; y += 0.125) {
        const LatticeSums s = lattice_sums(c.ratio, {x, y, 0.31}, c.mueller);
        gradient = std::max(gradient, s.gradient.norm());
      }
    EXPECT_LT(gradient, c.gradient_bound);
    RecordProperty("value_" + std::to_string(int(10 * c.ratio)) + (c.mueller ? "_mueller" : "_wendland"),
                   std::to_string(at_rest.value));
  }
}

}  // namespace
}  // namespace palp::test::smoothing_test
