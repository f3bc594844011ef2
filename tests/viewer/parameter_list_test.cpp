// The list of parameters as servers reply it, and as anyone else may.
#include "viewer/parameter_list.h"

#include <gtest/gtest.h>

namespace palp::test::parameter_list_test {
namespace {

TEST(ParameterList, HoldsNumbersWithTheirRange) {
  const auto list = read_parameter_list(
      "gravity\t0 0 -9.81\tm/s^2\t-100000\t100000\nnumerics.density_diffusion\t\t\t0\t0.5\n"
      "stream.scalar\tspeed\t\t\t\n");
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0], (ListedParameter{"gravity", {0, 0, -9.81}, "m/s^2", -1e5, 1e5}));
  EXPECT_EQ(list[1], (ListedParameter{"numerics.density_diffusion", {}, "", 0, 0.5}));
}

TEST(ParameterList, PassesOverWhatIsNone) {
  for (const char* text : {"", "\n\n", "a", "a\t1", "\t1\t\t0\t1", "a\tx\t\t0\t1", "a\t1 2 3 4\t\t0\t1", "a\t1\t\t1\t0",
                           "a\t1\t\tnan\tinf", "a\t1\t\t0\tinf"})
    EXPECT_TRUE(read_parameter_list(text).empty()) << text;
  std::string endless;
  for (int i = 0; i < 5000; ++i) endless += "a\t1\t\t0\t1\n";
  EXPECT_EQ(read_parameter_list(endless).size(), 300u);
}

TEST(ParameterList, NumbersAreWrittenAsSceneFilesHaveThem) {
  EXPECT_EQ(parameter_text({0, 0, -9.81}), "0 0 -9.81");
  EXPECT_EQ(parameter_text({0.05}), "0.05");
}

}  // namespace
}  // namespace palp::test::parameter_list_test
