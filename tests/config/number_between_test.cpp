#include "config/number_between.h"

#include <gtest/gtest.h>

namespace palp::test::number_between_test {
namespace {

// Returns what the program says of an option with this value; empty when it takes the value.
std::string refusal(const std::string& value) {
  CLI::App app;
  double number = -1;
  app.add_option("--seconds", number)->check(number_between(0, 1e6));
  try {
    app.parse("--seconds=" + value);
  } catch (const CLI::ParseError& error) {
    return error.what();
  }
  return "";
}

TEST(NumberBetween, TakesFiniteNumbersInRange) {
  for (const char* value : {"0", "1e6", "0.5", "1e-300", "999999.9"}) EXPECT_EQ(refusal(value), "") << value;
}

TEST(NumberBetween, RefusesEverythingElseInOneSentence) {
  for (const char* value :
       {"nan", "NaN", "-nan", "inf", "-inf", "infinity", "1e400", "-1e-300", "1000000.1", "fast", "1s", "nan(1)"}) {
    const std::string said = refusal(value);
    EXPECT_NE(said.find("--seconds: "), std::string::npos) << value << ": " << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
  EXPECT_EQ(refusal("nan"), "--seconds: expected a number from 0 to 1e+06, got 'nan'");
}

}  // namespace
}  // namespace palp::test::number_between_test
