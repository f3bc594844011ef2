// Reports for the table of tools/validate: a test that judges a validation case reports it with the same call, so that
// the table shows the numbers that were judged. The reports are GoogleTest properties (--gtest_output=json).
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/scene_config.h"
#include "tests/support/tolerance.h"

namespace palp::test {

// A row of the table, and a cell in it. Both methods of a case have the same name.
struct ValidationCase {
  std::string name;       // in plain words
  std::string reference;  // its value with unit, and whose it is
  std::string result;     // what was found, with unit
  Method method = Method::accurate;
  // Why method "paper" is known to miss the reference; null: it is judged like any other. Known misses are measured and
  // shown, and do not fail the test unless they are no numbers.
  const char* paper_is_off = nullptr;
  // Why both methods are known to miss the reference, as above.
  const char* is_off = nullptr;
};

// within(residual, tolerance), and reported. Of several reports of one case in a test the worst counts.
::testing::AssertionResult within(double residual, const Tolerance& tolerance, const ValidationCase& reported);

// Returns whether the test runs under tools/validate, which sets PALP_VALIDATE.
bool validating();

// The methods that a case is run in: "accurate", and under tools/validate "paper", too. For
// cases in which the paper's form is measured rather than judged; those that both must hold have both every day.
std::vector<Method> methods();

// "1.235 kPa", with four digits.
std::string quantity(double value, const std::string& unit);

// The numerics of what is reported from here on, as a simulation prints them; simulate() of backend.h calls it.
void computed_with(const std::string& numerics);

}  // namespace palp::test
