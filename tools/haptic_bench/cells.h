// Helpers that the metrics share: a run's set-up in a cell, and a row of the table for it.
#pragma once

#include <cmath>

#include "tools/haptic_bench/metrics.h"

namespace palp::bench {

inline RunSetup setup_in(const Scene& scene, const Cell& cell, HandScript hand, double seconds) {
  RunSetup s;
  s.scene = &scene;
  s.rate_hz = cell.rate_hz;
  s.link = cell.link;
  s.variant = cell.variant;
  s.seed = cell.seed;
  s.profile = cell.profile;
  s.controller = cell.controller;
  s.hand = std::move(hand);
  s.seconds = seconds;
  return s;
}

inline Row row_in(const Cell& cell, const std::string& metric, double result, const std::string& unit,
                  const std::string& reference, const std::string& target) {
  Row r;
  r.metric = metric;
  r.hand = cell.hand.name;
  r.link = cell.link.name;
  r.variant = to_string(cell.variant);
  r.rate_hz = cell.rate_hz;
  r.result = result;
  r.unit = unit;
  r.reference = reference;
  r.target = target;
  return r;
}

// Judges what we render, not the baselines.
inline Row judged(const Cell& cell, Row r, bool good, const std::string& trouble) {
  if (cell.variant == Variant::ours) r.pass = good && trouble.empty();
  if (!trouble.empty()) r.note = trouble + (r.note.empty() ? "" : "; " + r.note);
  return r;
}

// Returns a row that says by how much what is felt is off from what it should be: at most 5 %, the target of all
// rendering.
inline Row error_row(const Cell& cell, const std::string& what, double felt, double exact, const std::string& reference,
                     const std::string& note, const std::string& trouble) {
  const double error = 100 * std::abs(felt / exact - 1);
  Row r = row_in(cell, what + ", error", error, "%", reference, "<= 5");
  r.note = note;
  return judged(cell, r, error <= 5, trouble);
}

}  // namespace palp::bench
