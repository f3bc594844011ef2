// Tests the accuracy levels against what was measured: a level that another setting beats at its cost fails. The tables
// are config/trade/*.json; those of machines that palp was never measured on do not exist.
#include "sim_server/solver/levels.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "config/text_file.h"
#include "sim_server/trade/front.h"
#include "tests/support/tolerance.h"

namespace palp::test::levels_test {
namespace {

namespace fs = std::filesystem;

// Two runs of the same setting differ by less than this share in their mean step on a quiet machine, and in their
// error.
constexpr double kRepeats = 0.05;

// Returns whether two points have the very same particles and error: one run under two names, timed at two moments.
bool same_run(const TradePoint& a, const TradePoint& b) { return a.spacing == b.spacing && a.error == b.error; }

// Returns whether a point is clearly better than a level in one of cost and error, and no worse in the other one.
bool beats(const TradePoint& point, const TradePoint& level) {
  if (same_run(point, level)) return false;
  const bool errs_less = point.error * (1 + kRepeats) < level.error, cheaper = point.step * (1 + kRepeats) < level.step;
  return (errs_less && point.step <= level.step * (1 + kRepeats)) || (cheaper && point.error <= level.error);
}

// The class on whose fronts levels are chosen, by the rule of ARCHITECTURE.md.
constexpr const char* kChosenOn = "cpu-2";

// Returns whether a point is clearly better than a level in both cost and error.
bool beats_in_both(const TradePoint& point, const TradePoint& level) {
  return point.error * (1 + kRepeats) < level.error && point.step * (1 + kRepeats) < level.step;
}

// Returns whether matter stays where it rests (Rest, tests/cases/rest_test.cpp); not known counts as no.
bool rests(const TradePoint& point) { return point.rest_drift && *point.rest_drift < value_of(tol::kRestDrift); }

// Returns a sentence for each level of a scene that another point beats. A level is one setting for all machines: where
// it was chosen nothing may beat it; elsewhere nothing may in both cost and error. On a GPU small scenes cost what
// their launches cost, whatever the numerics, so something coarse errs less than a level there at no cost, and costs
// three times as much on a CPU. One whose matter stays where it rests is beaten only by what keeps it there, too.
std::vector<std::string> beaten_levels(const TradeScene& scene, const std::string& machine_class) {
  const auto better = machine_class == kChosenOn ? beats : beats_in_both;
  std::vector<std::string> faults;
  for (const auto& [name, level] : scene.levels) {
    for (const TradePoint& point : scene.points) {
      if (!better(point, level) || (rests(level) && !rests(point))) continue;
      faults.push_back(
          fmt::format("{}: {} ({} m, {:.3g} s, error {:.3g}) is beaten by {} m, {:.3g} s, error {:.3g} ({})",
                      scene.name, name, level.spacing, level.step, level.error, point.spacing, point.step, point.error,
                      point.settings.empty() ? "" : point.settings.front()));
      break;
    }
  }
  return faults;
}

// Returns a sentence for each number that a level was measured with and that is no longer the level's.
std::vector<std::string> outdated_levels(const TradeScene& scene) {
  std::vector<std::string> faults;
  for (const Accuracy accuracy : {Accuracy::fast, Accuracy::balanced, Accuracy::accurate}) {
    const auto measured = scene.levels.find(to_string(accuracy));
    if (measured == scene.levels.end()) continue;
    const Level level = level_of(accuracy);
    for (const std::string& setting : measured->second.settings) {
      const std::string key = key_of(setting);
      const double value = parse_number(palp::value_of(setting)).value_or(-1);
      const bool outdated = (key == "numerics.support_over_spacing" && value != level.support_over_spacing) ||
                            (key == "numerics.artificial_viscosity" && value != level.artificial_viscosity &&
                             value != level.rough_viscosity);
      if (outdated)
        faults.push_back(fmt::format("{}: {} was measured with {}", scene.name, to_string(accuracy), setting));
    }
  }
  return faults;
}

// Returns the method that a point was measured with; a scene keeps its own.
std::string method_of(const TradePoint& point) {
  for (const std::string& setting : point.settings)
    if (key_of(setting) == "scene.method") return palp::value_of(setting);
  return to_string(Method::accurate);
}

// Returns a sentence for each stored point that another one of its method dominates: what is stored is the front.
std::vector<std::string> beaten_points(const TradeScene& scene) {
  std::vector<std::string> faults;
  for (const TradePoint& a : scene.points)
    for (const TradePoint& b : scene.points)
      if (method_of(a) == method_of(b) && dominates(b, a))
        faults.push_back(
            fmt::format("{}: the point at {} m is beaten by that at {} m", scene.name, a.spacing, b.spacing));
  return faults;
}

std::vector<TradeTable> stored_tables() {
  std::vector<TradeTable> tables;
  for (const auto& entry : fs::directory_iterator(PALP_SOURCE_DIR "/config/trade"))
    if (entry.path().extension() == ".json") tables.push_back(read_trade_table(entry.path().string()));
  return tables;
}

TEST(Levels, AreOnTheMeasuredFront) {
  for (const TradeTable& table : stored_tables())
    for (const TradeScene& scene : table.scenes) {
      SCOPED_TRACE(table.file);
      EXPECT_EQ(beaten_levels(scene, table.machine_class), std::vector<std::string>());
      EXPECT_EQ(beaten_points(scene), std::vector<std::string>());
    }
}

TEST(Levels, AreWhatWasMeasured) {
  for (const TradeTable& table : stored_tables())
    for (const TradeScene& scene : table.scenes) {
      SCOPED_TRACE(table.file);
      EXPECT_EQ(outdated_levels(scene), std::vector<std::string>());
    }
}

TEST(Levels, CostMoreAndErrLessFromOneToTheNext) {
  for (const TradeTable& table : stored_tables())
    for (const TradeScene& scene : table.scenes) {
      SCOPED_TRACE(table.file + ", " + scene.name);
      const TradePoint* before = nullptr;
      for (const char* name : {"fast", "balanced", "accurate"}) {
        const auto level = scene.levels.find(name);
        if (level == scene.levels.end()) continue;
        const bool same = before && same_run(*before, level->second);
        EXPECT_TRUE(!before || same || before->step <= (1 + kRepeats) * level->second.step) << name;
        EXPECT_TRUE(!before || (1 + kRepeats) * before->error >= level->second.error) << name;
        before = &level->second;
      }
    }
}

// The judge itself, judged.
TEST(Levels, ALevelThatIsBeatenIsFound) {
  TradePoint level{0.02, {"numerics.artificial_viscosity=0.05"}, 5.9e-4, 8e-4, 5e-4, 0.25};
  TradePoint better{0.02, {"numerics.artificial_viscosity=0.02"}, 6.0e-4, 8e-4, 5e-4, 0.12};
  TradeScene scene;
  scene.name = "tray_fluid";
  scene.points = {better};
  scene.levels = {{"balanced", level}};
  EXPECT_EQ(beaten_levels(scene, kChosenOn).size(), 1u);
  EXPECT_TRUE(beaten_levels(scene, "h200").empty()) << "at the same cost";
  better.step = 5e-4;
  scene.points = {better};
  EXPECT_EQ(beaten_levels(scene, "h200").size(), 1u);
  scene.points = {level};
  EXPECT_TRUE(beaten_levels(scene, kChosenOn).empty()) << "itself";
  better.step = 6.3e-4;
  scene.points = {better};
  EXPECT_TRUE(beaten_levels(scene, kChosenOn).empty()) << "at a higher cost";
  scene.points = {level, better};
  better.error = 0.3;
  scene.points.push_back(better);
  EXPECT_EQ(beaten_points(scene).size(), 2u);
  scene.levels["balanced"].settings = {"numerics.support_over_spacing=2"};
  EXPECT_EQ(outdated_levels(scene).size(), 1u);
}

TEST(Levels, OneThatRestsIsBeatenByWhatRestsAlone) {
  TradePoint level{0.03, {}, 5e-4, 8e-4, 5e-4, 0.4, 0.05}, better{0.03, {}, 5e-4, 8e-4, 5e-4, 0.3};
  TradeScene scene;
  for (const std::optional<double> drift : {std::optional<double>(), {0.5}, {0.09}}) {
    better.rest_drift = drift;
    scene.points = {better};
    level.rest_drift = 0.05;
    scene.levels = {{"fast", level}};
    EXPECT_EQ(beaten_levels(scene, kChosenOn).empty(), drift != 0.09) << drift.value_or(-1);
    level.rest_drift = 0.5;
    scene.levels = {{"fast", level}};
    EXPECT_FALSE(beaten_levels(scene, kChosenOn).empty()) << "it creeps itself";
  }
}

}  // namespace
}  // namespace palp::test::levels_test
