// Tables of the trade are read strictly: what is wrong in one is told in a sentence with its place.
#include "sim_server/trade/trade_table.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/error.h"
#include "tests/support/files.h"

namespace palp::test::trade_table_test {
namespace {

const std::string kSynthetic = PALP_SOURCE_DIR "/tests/sim_server/trade/synthetic.json";

std::string refusal(const std::string& path) {
  try {
    read_trade_table(path);
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.faults().size(), 1u);
    return error.what();
  }
  return "";
}

TEST(TradeTable, IsReadWithPointsSettingsAndLevels) {
  const TradeTable table = read_trade_table(kSynthetic);
  EXPECT_EQ(table.machine_class, "synthetic");
  EXPECT_EQ(table.date, "2000-01-01");
  ASSERT_EQ(table.scenes.size(), 2u);
  const TradeScene& scene = table.scenes[0];
  EXPECT_EQ(scene.name, "tray_fluid");
  EXPECT_EQ(scene.medium, "fluid");
  EXPECT_EQ(scene.date + " " + scene.commit, "2000-01-01 0000000") << "the table's";
  EXPECT_EQ(table.scenes[1].date + " " + table.scenes[1].commit, "2000-01-02 0000001") << "its own";
  EXPECT_EQ(scene.uncertainty, 0.02);
  ASSERT_EQ(scene.points.size(), 3u);
  EXPECT_EQ(scene.points[0].spacing, 0.08);
  EXPECT_EQ(scene.points[0].settings,
            (std::vector<std::string>{"numerics.artificial_viscosity=0.02", "numerics.support_over_spacing=3"}));
  EXPECT_EQ(scene.points[2].calm_step, 6.4e-4);
  EXPECT_LT(scene.points[1].calm_step, scene.points[1].step) << "a fluid at rest lists its neighbours less often";
  EXPECT_EQ(table.scenes[1].points[0].calm_step, 3e-4) << "an elastic body does not";
  EXPECT_EQ(scene.levels.at("fast").error, 0.4);
}

struct Spoilt {
  std::string from, to;  // text of the table that is replaced
  std::string told;
};

const char* const kFirst = "\"spacing_m\": 0.08";
const char* const kCost = "\"step_mean_s\": 1e-4";
const Spoilt kSpoilt[] = {
    Spoilt{"{", "]", "this is no JSON"},
    Spoilt{"\"class\"", "\"klass\"", "has no 'class'"},
    Spoilt{"\"synthetic\"", "\"h200\"", "class is 'h200', expected 'synthetic'"},
    Spoilt{"\"synthetic\"", "17", "class is 17, expected a text"},
    Spoilt{kFirst, "\"spacing_m\": -0.08", "scenes.tray_fluid.points[0]: spacing_m is -0.08"},
    Spoilt{kFirst, "\"spacing_m\": null", "spacing_m is null"},
    Spoilt{kFirst, "\"spacing_m\": NaN", "this is no JSON"},
    Spoilt{kFirst, "\"spacing_m\": 1e999", "this is no JSON"},
    Spoilt{kFirst, "\"spacing_m\": \"fine\"", "spacing_m is \"fine\""},
    Spoilt{kFirst, "\"spacing\": 0.08", "points[0]: has no 'spacing_m'"},
    Spoilt{kCost, "\"step_mean_s\": 0", "step_mean_s is 0"},
    Spoilt{kCost, "\"rest_drift_spacings\": -1, \"step_mean_s\": 1e-4", "rest_drift_spacings is -1"},
    Spoilt{"\"step_p99_s\": 2e-4", "\"step_p99_s\": 0", "step_p99_s is 0"},
    Spoilt{kCost + std::string(", \"step_p99_s\": 2e-4"), "\"step_mean_s\": 1, \"step_p99_s\": 1",
           "points[1]: costs less than the point before it"},
    Spoilt{"\"error\": 0.4", "\"error\": -0.4", "error is -0.4"},
    Spoilt{"\"error\": 0.4", "\"error\": [0.4]", "error is [0.4]"},
    Spoilt{"\"uncertainty\": 0.02", "\"uncertainty\": null", "reference: uncertainty is null"},
    Spoilt{"\"medium\": \"fluid\"", "\"medium\": \"\"", "medium is \"\""},
    Spoilt{"{\"scene.method\": \"paper\"}", "[1]", "points[1]: set is no object"},
    Spoilt{"\"paper\"}", "{}}", "set has 'scene.method'"},
    Spoilt{"\"levels\": {", "\"levels\": 3, \"x\": {", "levels is no object"},
    Spoilt{"\"fast\": {", "\"fast\": 3, \"x\": {", "levels.fast: is number, expected an object"}};

TEST(TradeTable, HostileOnesAreRefusedInOneSentenceThatNamesThePlace) {
  const ScratchFolder folder;
  const std::string file = folder / "synthetic.json";
  for (const Spoilt& row : kSpoilt) {
    SCOPED_TRACE(row.from + " -> " + row.to);
    std::string text = text_of(kSynthetic);
    const std::size_t place = text.find(row.from);
    ASSERT_NE(place, std::string::npos);
    write_text(file, text.replace(place, row.from.size(), row.to));
    const std::string said = refusal(file);
    EXPECT_EQ(said.rfind(file + ": ", 0), 0u) << said;
    EXPECT_NE(said.find(row.told), std::string::npos) << said;
    EXPECT_NE(said.find("tools/tradeoff"), std::string::npos) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
}

TEST(TradeTable, EmptyOnesAreRefused) {
  const ScratchFolder folder;
  const std::string file = folder / "t.json";
  const std::string head = R"({"class": "t", "date": "2000-01-01", "scenes": )";
  const std::pair<std::string, std::string> rows[] = {
      {"", "this is no JSON"},
      {"[]", "is array, expected an object"},
      {head + "{}}", "scenes is no object with at least one scene"},
      {head + "[]}", "scenes is no object"},
      {head + R"({"a": 3}})", "scenes.a: is number, expected an object"},
      {head + R"({"a": {"medium": "fluid", "points": []}}})", "scenes.a: points is no list with at least one point"},
      {head + R"({"a": {"medium": "fluid", "points": [[]]}}})", "scenes.a.points[0]: is array"}};
  for (const auto& [text, told] : rows) {
    write_text(file, text);
    EXPECT_NE(refusal(file).find(told), std::string::npos) << text << ": " << refusal(file);
  }
  EXPECT_EQ(refusal("/no/such/table.json").rfind("/no/such/table.json: ", 0), 0u);
  write_text(file, std::string(100000, '['));  // deeply nested
  EXPECT_NE(refusal(file).find("this is no JSON"), std::string::npos);
}

}  // namespace
}  // namespace palp::test::trade_table_test
