// Spacing and numerics that palp-run chooses for a budget or an error, by a table that was made up.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/support/files.h"
#include "tests/support/process.h"

namespace palp::test::chosen_numerics_test {
namespace {

namespace fs = std::filesystem;

// A folder of palp's own files with the made-up table in place of those that were measured.
class ChosenNumerics : public testing::Test {
 protected:
  ChosenNumerics() {
    for (const char* kind : {"scenes", "hands", "devices"})
      fs::create_directory_symlink(fs::path(PALP_SOURCE_DIR) / "config" / kind, folder_ / kind);
    fs::create_directory(folder_ / "trade");
    fs::copy_file(PALP_SOURCE_DIR "/tests/sim_server/trade/synthetic.json", table_);
  }
  Outcome run(std::vector<std::string> options) const {
    const std::vector<std::string> all{"env",
                                       "-C",
                                       folder_.path().string(),
                                       "PALP_DATA_DIR=" + folder_.path().string(),
                                       PALP_BIN_DIR "/palp-run",
                                       "--backend",
                                       "cpu",
                                       "--out",
                                       out_,
                                       "--duration",
                                       "0.002"};
    options.insert(options.begin(), all.begin(), all.end());
    return run_program(options);
  }
  nlohmann::json summary() const { return nlohmann::json::parse(text_of(out_ + "/summary.json")); }

  const ScratchFolder folder_;
  const std::string out_ = folder_ / "out", table_ = folder_ / "trade/synthetic.json";
};

TEST_F(ChosenNumerics, AnErrorGivesTheCoarsestMeasuredSpacingThatErrsNoMore) {
  const Outcome outcome = run({"tray_fluid", "--error", "20%"});
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("chosen for an error of 20 %: a spacing of 40 mm"), std::string::npos)
      << outcome.output;
  const nlohmann::json told = summary(), chosen = told.at("chosen");
  EXPECT_EQ(told.at("spacing_m").get<double>(), 0.04) << "8 cm err by 40 %, what lies between was not measured";
  EXPECT_EQ(chosen.at("spacing_m"), told.at("spacing_m"));
  EXPECT_EQ(chosen.at("expected_error").get<double>(), 0.1);
  EXPECT_GT(chosen.at("expected_step_s").get<double>(), 0);
  EXPECT_EQ(chosen.at("measured_with"), "tray_fluid");
  EXPECT_EQ(chosen.at("table"), table_);
  EXPECT_NE(told.at("numerics").get<std::string>().find("H 3 dx"), std::string::npos);
  EXPECT_NE(told.at("numerics").get<std::string>().find("alpha 0.02"), std::string::npos);
  EXPECT_NE(told.at("numerics").get<std::string>().find(", chosen for an error of 20 %: a step of "),
            std::string::npos);

  // what is printed as the same again is
  const std::size_t place = outcome.output.find("the same again: ");
  ASSERT_NE(place, std::string::npos);
  std::istringstream options(outcome.output.substr(place + 16, outcome.output.find('\n', place) - place - 16));
  std::vector<std::string> again{"tray_fluid"};
  for (std::string word; options >> word;) again.push_back(word);
  ASSERT_EQ(run(again).status, 0);
  EXPECT_EQ(summary().at("particles"), told.at("particles"));
  EXPECT_EQ(summary().at("max_speed_m_s"), told.at("max_speed_m_s")) << "the same bits";
  EXPECT_TRUE(summary().at("chosen").is_null());
}

TEST_F(ChosenNumerics, AGenerousBudgetGivesTheMostAccurate) {
  ASSERT_EQ(run({"tray_fluid", "--budget", "100s"}).status, 0);
  EXPECT_EQ(summary().at("spacing_m"), 0.04);
  EXPECT_EQ(summary().at("chosen").at("asked"), "a budget of 100 s");
}

TEST_F(ChosenNumerics, WhatIsImpossibleIsRefusedInOneSentence) {
  const std::pair<std::vector<std::string>, std::string> rows[] = {
      {{"tray_fluid", "--budget", "1us"}, "no numerics that were measured take a step of at most 1 us"},
      {{"tray_fluid", "--error", "5%"}, "the most accurate, a spacing of 40 mm, is expected to err by 10 %"},
      {{"tray_fluid", "--error", "1%"},
       "an error of 1 % cannot be told: the force of tray_fluid that errors were "
       "measured against is itself known within 2 % only"},
      {{"butter", "--error", "1%"}, "no curve for a scene whose medium is changing"},
      {{"tray_fluid", "--error", "5"}, "--error: expected a share of the force"},
      {{"tray_fluid", "--budget", "1"}, "--budget: expected a time with its unit"},
      {{"tray_fluid", "--budget", "1ms", "--error", "5%"}, "excludes"},
      {{"tray_fluid", "--budget", "1ms", "--spacing", "0.02"}, "excludes"},
      {{"tray_fluid", "--error", "20%", "--accuracy", "fast"}, "excludes"},
      {{"tray_fluid", "--error", "20%", "--particles", "1000"}, "excludes"},
      {{"tray_fluid", "--error", "20%", "--set", "numerics.spacing=0.02"}, "chooses that: leave out one of the two"}};
  for (const auto& [options, told] : rows) {
    SCOPED_TRACE(told);
    const Outcome outcome = run(options);
    EXPECT_EQ(outcome.status, 2) << outcome.output;
    EXPECT_NE(outcome.output.find(told), std::string::npos) << outcome.output;
  }
  write_text(table_, "garbage");
  const Outcome spoilt = run({"tray_fluid", "--error", "20%"});
  EXPECT_EQ(spoilt.status, 2);
  EXPECT_EQ(spoilt.output.rfind("palp-run: " + table_ + ": this is no JSON", 0), 0u) << spoilt.output;
  fs::remove(table_);
  EXPECT_NE(run({"tray_fluid", "--error", "20%"}).output.find("there is no table of what numerics cost and err"),
            std::string::npos);
}

}  // namespace
}  // namespace palp::test::chosen_numerics_test
