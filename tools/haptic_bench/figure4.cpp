// The motion of the paper's figure 4 (section 6.1) through the whole loop: a spoon goes down into a tray until it feels
// 5 N, then aside for 1.6 s, then up; once for a tray of each state of matter. What the tray adds to the force that the
// spoon has in air is what is looked at.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <fstream>
#include <optional>

#include "config/error.h"
#include "sim_server/scene/scene_files.h"
#include "tools/haptic_bench/bench_scenes.h"
#include "tools/haptic_bench/cells.h"
#include "tools/haptic_bench/series.h"

namespace palp::bench {

namespace {

constexpr double kThreshold = 5;             // [N]
constexpr double kTouch = 0.1;               // [N]
constexpr double kAside = 1.6;               // [s]
constexpr double kDownSpeed = 0.025;         // the paper does not say; so that stone takes its 0.2 s [m/s]
constexpr double kAsideSpeed = 0.05;         // [m/s]
constexpr double kWait = 1.5;                // until the hand has taken hold, and a free surface has come to rest [s]
constexpr double kSettled = 0.3;             // of the way aside is over [s]
constexpr double kDeepest = 0.19;            // below where the spoon begins; a tray is 0.2 deep [m]
constexpr double kRippleHz = 5;              // slower is the motion, and the spoon that swings on its soft coupling
constexpr HandModel kPlayed{0.5, 200, 2e4};  // goes the way whatever it feels

struct Medium {
  const char* scene;
  const char* name;
  const char* reference;
};
constexpr std::array<Medium, 3> kMedia{
    {{"tray_rigid", "stone", "0.2"}, {"tray_elastic", "jelly", "0.8"}, {"tray_fluid", "oil", "1.8"}}};

// Straight from place to place at constant speed: a key every 20 ms.
class Way {
 public:
  explicit Way(double wait) { script_.hand = kPlayed, script_.interpolation = Interpolation::catmull_rom, stay(wait); }
  void stay(double during) { go(during, Eigen::Vector3d::Zero()); }
  void go(double during, const Eigen::Vector3d& by) {
    const int keys = std::max(1, static_cast<int>(std::lround(during / 0.02)));
    for (int k = script_.keyframes.empty() ? 0 : 1; k <= keys; ++k)
      script_.keyframes.push_back({time_ + during * k / keys, place_ + static_cast<double>(k) / keys * by});
    time_ += during;
    place_ += by;
  }
  double time() const { return time_; }
  const HandScript& script() const { return script_; }

 private:
  HandScript script_;
  double time_ = 0;
  Eigen::Vector3d place_ = Eigen::Vector3d::Zero();
};

struct Play {
  Trace trace;
  Eigen::Vector3d air;            // mean force on the spoon before it touches [N]
  bool felt;                      // the threshold; else the way down ended first
  double touched, reached, ends;  // [s]: force of the tray, the way down's end, the way aside's
};

double vertical(const Tick& t, const Eigen::Vector3d& air) { return t.force.z() - air.z(); }

Play play(const Scene& scene, const Cell& cell) {
  Way down(kWait);
  down.go(kDeepest / kDownSpeed, {0, 0, -kDeepest});
  RunSetup s = setup_in(scene, cell, down.script(), down.time());
  s.stop = [air = 0.0](const Tick& t) mutable {
    if (t.t < kWait) air += 0.01 * (t.force.z() - air);
    return t.t > kWait && t.force.z() - air > kThreshold;
  };
  Play p;
  const Trace first = run(s);
  p.reached = first.ticks.back().t;
  p.felt = p.reached < down.time() - 0.01 && first.trouble.empty();

  Way way(kWait);
  way.go(p.reached - kWait, {0, 0, -kDownSpeed * (p.reached - kWait)});
  way.go(kAside, {kAsideSpeed * kAside, 0, 0});
  p.ends = way.time();
  way.go(p.reached - kWait, {0, 0, kDownSpeed * (p.reached - kWait)});
  way.stay(0.3);
  s.hand = way.script();
  s.seconds = way.time();
  s.stop = nullptr;
  p.trace = run(s);
  for (int a = 0; a < 3; ++a)
    p.air[a] = mean(taken(p.trace, kWait - 0.3, kWait, [a](const Tick& t) { return t.force[a]; }));
  p.touched = p.reached;
  for (auto t = p.trace.ticks.rbegin(); t != p.trace.ticks.rend(); ++t)
    if (t->t < p.reached && t->t > kWait) {
      if (vertical(*t, p.air) < kTouch) break;
      p.touched = t->t;
    }
  return p;
}

// Describes the force across the way's direction and time: how straight it grows, and what it is in the end.
std::string aside_in_words(const Play& p) {
  const auto across = [&](double from, double to) {
    return mean(taken(p.trace, from, to, [&](const Tick& t) { return t.force.x() - p.air.x(); }));
  };
  const auto normal =
      mean(taken(p.trace, p.reached + kSettled, p.ends, [&](const Tick& t) { return vertical(t, p.air); }));
  return fmt::format(
      "force against the way aside {:.2g} N after 0.2 s, {:.2g} N halfway, {:.2g} N at its end; upward {:.2g} N",
      -across(p.reached + 0.15, p.reached + 0.25), -across(p.reached + 0.75, p.reached + 0.85),
      -across(p.ends - 0.1, p.ends), normal);
}

// Returns the ripple of the upward force on the way aside, in per cent of its mean.
double ripple(const Play& p) {
  const Series up = taken(p.trace, p.reached + kSettled, p.ends, [&](const Tick& t) { return vertical(t, p.air); });
  return 100 * rms_above(up, kRippleHz) / mean(up);
}

void write(const std::string& file, const Play& p) {
  std::ofstream out(file);
  out << "time_s,force_x_n,force_y_n,force_z_n,torque_x_nm,torque_y_nm,torque_z_nm\n";
  for (const Tick& t : p.trace.ticks) {
    const Eigen::Vector3d f = t.force - p.air;
    out << fmt::format("{:.3f},{:.5f},{:.5f},{:.5f},{:.6f},{:.6f},{:.6f}\n", t.t - p.touched, f.x(), f.y(), f.z(),
                       t.torque.x(), t.torque.y(), t.torque.z());
  }
  if (!out.flush()) throw ConfigError(file + ": cannot be written");
}

}  // namespace

std::vector<Row> figure4_rows(const Cell& cell, std::optional<Accuracy> accuracy, const std::string& series_dir) {
  std::vector<Row> rows;
  std::array<double, 2> rippled{};
  for (const Method method : {Method::paper, Method::accurate}) {
    double before = 0;
    for (const Medium& medium : kMedia) {
      SceneOverrides overrides;
      overrides.method = method;
      overrides.accuracy = accuracy;
      const Scene scene = sample_scene(load_scene(find_scene_file(medium.scene), overrides), kMostParticles);
      const Play p = play(scene, cell);
      if (!series_dir.empty()) write(fmt::format("{}/{}_{}.csv", series_dir, medium.scene, to_string(method)), p);
      const double took = p.reached - p.touched;
      Row r =
          row_in(cell, fmt::format("spoon down on {}, from touch to 5 N, method {}", medium.name, to_string(method)),
                 took, "s", medium.reference, "longer than the one before");
      r.note = (p.felt ? "" : fmt::format("not felt {:.0f} cm below the start; ", 100 * kDeepest)) + aside_in_words(p);
      // method paper stands beside ours for comparison
      r = judged(cell, r, p.felt && took > before, p.trace.trouble);
      if (method == Method::paper) r.pass.reset();
      rows.push_back(r);
      before = took;
      if (&medium == &kMedia.front()) rippled[method == Method::accurate] = ripple(p);
    }
  }
  Row r = row_in(cell, "spoon aside on stone, ripple of the upward force, rms", rippled[1], "%", "paper: bumpy",
                 "below method paper's");
  r.note = fmt::format("method paper {:.2g} %", rippled[0]);
  rows.push_back(judged(cell, r, rippled[1] < rippled[0], ""));
  return rows;
}

}  // namespace palp::bench
