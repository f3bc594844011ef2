// Times and shares as people type them.
#include "config/quantity.h"

#include <gtest/gtest.h>

#include "config/error.h"

namespace palp::test::quantity_test {
namespace {

std::string refusal(double (*parse)(const std::string&), const std::string& text) {
  try {
    parse(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(Quantity, TimesHaveAUnit) {
  EXPECT_DOUBLE_EQ(parse_duration("500us"), 500e-6);
  EXPECT_DOUBLE_EQ(parse_duration("0.5ms"), 500e-6);
  EXPECT_DOUBLE_EQ(parse_duration("5e-4s"), 500e-6);
  EXPECT_DOUBLE_EQ(parse_duration("500 \xc2\xb5s"), 500e-6);
  for (const char* text :
       {"", "us", "500", "0.5 m", "nanms", "infs", "-1ms", "0s", "0.5us", "101s", "1e400s", "5msec"}) {
    const std::string said = refusal(parse_duration, text);
    EXPECT_EQ(said.rfind("expected a time ", 0), 0u) << text << ": " << said;
  }
}

TEST(Quantity, SharesAreOfOneOrInPercent) {
  EXPECT_DOUBLE_EQ(parse_share("5%"), 0.05);
  EXPECT_DOUBLE_EQ(parse_share("0.05"), 0.05);
  EXPECT_DOUBLE_EQ(parse_share("100 %"), 1);
  for (const char* text : {"", "%", "5", "0", "0%", "-5%", "nan", "nan%", "101%", "5 percent", "1e400"}) {
    const std::string said = refusal(parse_share, text);
    EXPECT_EQ(said.rfind("expected a share of the force ", 0), 0u) << text << ": " << said;
  }
}

TEST(Quantity, AreToldInTheUnitThatSuitsThem) {
  EXPECT_EQ(duration_text(462.3e-6), "462 us");
  EXPECT_EQ(duration_text(1.5e-3), "1.5 ms");
  EXPECT_EQ(duration_text(2), "2 s");
  EXPECT_EQ(share_text(0.0456), "4.6 %");
}

}  // namespace
}  // namespace palp::test::quantity_test
