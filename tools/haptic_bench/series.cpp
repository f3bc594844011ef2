#include "tools/haptic_bench/series.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <Eigen/Dense>

namespace palp::bench {

namespace {

constexpr double kTick = 1e-3;  // [s]

std::complex<double> fourier(const Series& s, double hz) {
  std::complex<double> sum = 0;
  for (std::size_t k = 0; k < s.size(); ++k)
    sum += s[k] * std::polar(1.0, -2 * M_PI * hz * kTick * static_cast<double>(k));
  return 2.0 / static_cast<double>(s.size()) * sum;
}

Series without_line(Series s) {
  const double n = static_cast<double>(s.size()), middle = (n - 1) / 2, m = mean(s);
  double slope = 0;
  for (std::size_t k = 0; k < s.size(); ++k) slope += (static_cast<double>(k) - middle) * (s[k] - m);
  slope /= n * (n * n - 1) / 12;
  for (std::size_t k = 0; k < s.size(); ++k) s[k] -= m + slope * (static_cast<double>(k) - middle);
  return s;
}

// Halfway between each value and the next.
Series between(Series s) {
  for (std::size_t k = 0; k + 1 < s.size(); ++k) s[k] = (s[k] + s[k + 1]) / 2;
  if (!s.empty()) s.pop_back();
  return s;
}

SpringDamper fit(const Series& force, const Series& x, const Series& v) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < force.size(); ++k) {
    const Eigen::Vector3d row(1, -x[k], -v[k]);
    A += row * row.transpose();
    b += force[k] * row;
  }
  const Eigen::Vector3d solution = A.ldlt().solve(b);
  return {solution[1], solution[2]};
}

}  // namespace

Series taken(const Trace& trace, double from, double to, const OfTick& get) {
  Series s;
  for (const Tick& t : trace.ticks)
    if (t.t >= from - 1e-9 && t.t < to - 1e-9) s.push_back(get(t));
  return s;
}

double mean(const Series& s) {
  double sum = 0;
  for (const double x : s) sum += x;
  return s.empty() ? 0 : sum / static_cast<double>(s.size());
}

double rms(const Series& s) {
  double sum = 0;
  for (const double x : s) sum += x * x;
  return s.empty() ? 0 : std::sqrt(sum / static_cast<double>(s.size()));
}

double spread(const Series& s) {
  if (s.empty()) return 0;
  const auto [low, high] = std::minmax_element(s.begin(), s.end());
  return *high - *low;
}

double quantile(Series s, double share) {
  if (s.empty()) return 0;
  const auto at = s.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(s.size() - 1));
  std::nth_element(s.begin(), at, s.end());
  return *at;
}

double amplitude(const Series& s, double hz) { return s.empty() ? 0 : std::abs(fourier(s, hz)); }

double rms_above(const Series& series, double hz) {
  if (series.size() < 3) return 0;
  const Series s = without_line(series);
  const double total = rms(s), step = 1 / (kTick * static_cast<double>(s.size()));
  double slow = 0;
  for (double f = step; f <= hz; f += step) slow += std::norm(fourier(s, f)) / 2;
  return std::sqrt(std::max(0.0, total * total - slow));
}

SpringDamper felt(const Trace& trace, double from, double to, const OfTick& force, const OfTick& x, const OfTick& v) {
  Series held = taken(trace, from, to, force);
  if (!held.empty()) held.pop_back();
  return fit(held, between(taken(trace, from, to, x)), between(taken(trace, from, to, v)));
}

}  // namespace palp::bench
