#include "sim_server/solver/health_report.h"

#include <algorithm>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace palp {
namespace {

// The share of an implicit solve's result from which on its last round is said to have left too much: what
// elastic_plan.cpp chooses the rounds for.
constexpr double kUnsolved = 0.01;

}  // namespace

void HealthRecord::add(const Health& h) {
  const auto first = [](std::string& kept, const std::string& now) {
    if (kept.empty()) kept = now;
  };
  if (worst.ok && !h.ok) worst.cause = h.cause;
  worst.ok = worst.ok && h.ok;
  first(worst.doubt, h.doubt);
  first(worst.notice, h.notice);
  worst.non_finite = std::max(worst.non_finite, h.non_finite);
  worst.max_speed = std::max(worst.max_speed, h.max_speed);
  worst.expected_speed = h.expected_speed;
  worst.max_compression = std::max(worst.max_compression, h.max_compression);
  worst.mean_compression = std::max(worst.mean_compression, h.mean_compression);
  worst.expected_compression = h.expected_compression;
  worst.kinetic_energy = std::max(worst.kinetic_energy, h.kinetic_energy);
  worst.solves = h.solves;
  worst.unsolved = std::max(worst.unsolved, h.unsolved);
  worst.outside = std::max(worst.outside, h.outside);
  worst.inactive = std::max(worst.inactive, h.inactive);
  worst.inactive_mass = std::max(worst.inactive_mass, h.inactive_mass);
}

std::string describe(const HealthRecord& record) {
  const Health& w = record.worst;
  std::string text = w.non_finite == 0 ? "finite" : fmt::format("{} particles not finite", w.non_finite);
  if (w.expected_speed > 0)
    text += fmt::format(", speeds to {:.3g} m/s of {:.3g} expected", w.max_speed, w.expected_speed);
  if (w.expected_compression > 0)
    text += fmt::format(", compression {:.2g} % on average and {:.2g} % at a peak of {:.2g} % expected",
                        100 * w.mean_compression, 100 * w.max_compression, 100 * w.expected_compression);
  if (w.solves)
    text += w.unsolved <= kUnsolved ? ", elastic solve converged"
                                    : fmt::format(", elastic solve left {:.2g} % unsolved", 100 * w.unsolved);
  if (w.outside == 0) return text + ", nothing left the domain";
  text += fmt::format(", {} particles left the domain", w.outside);
  return w.inactive > 0 ? text + fmt::format(" ({:.2g} kg of fluid is gone)", w.inactive_mass) : text;
}

Json json_of(const HealthRecord& record) {
  const Health& w = record.worst;
  return {{"checked", describe(record)},
          {"notice", w.notice},
          {"most_speed_m_s", w.max_speed},
          {"expected_speed_m_s", w.expected_speed},
          {"most_compression", w.max_compression},
          {"most_mean_compression", w.mean_compression},
          {"expected_compression", w.expected_compression},
          {"most_kinetic_energy_J", w.kinetic_energy},
          {"most_elastic_unsolved", w.unsolved},
          {"most_particles_outside", w.outside}};
}

}  // namespace palp
