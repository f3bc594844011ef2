#include "tests/support/validation.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <utility>

#include <nlohmann/json.hpp>

#include "tests/support/backend.h"

namespace palp::test {
namespace {

struct Reported {
  int number = 0;
  double share = 0;  // of the tolerance
};

// The reports of the running test, by name and method.
struct Reports {
  const ::testing::TestInfo* test = nullptr;
  std::map<std::pair<std::string, Method>, Reported> reported;
  std::string numerics;
};

Reports& reports() {
  static Reports all;
  const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
  if (all.test != test) all = {test, {}, {}};
  return all;
}

const char* back_end() {
  return tested_backend() == Backend::cuda ? "cuda" : sizeof(real) == sizeof(double) ? "double" : "cpu";
}

}  // namespace

::testing::AssertionResult within(double residual, const Tolerance& tolerance, const ValidationCase& reported) {
  Reports& all = reports();
  const double limit = value_of(tolerance), error = std::abs(residual);
  // what is no number is worse than any number
  const double share = std::isfinite(error) ? error / limit : INFINITY;
  const auto [place, is_new] = all.reported.try_emplace({reported.name, reported.method},
                                                        Reported{static_cast<int>(all.reported.size()), share});
  const char* off = reported.is_off != nullptr         ? reported.is_off
                    : reported.method == Method::paper ? reported.paper_is_off
                                                       : nullptr;
  const bool known = off != nullptr && std::isfinite(error);
  if (is_new || share > place->second.share) {
    place->second.share = share;
    nlohmann::json row{{"case", reported.name},     {"method", to_string(reported.method)},
                       {"back_end", back_end()},    {"reference", reported.reference},
                       {"result", reported.result}, {"error", std::isfinite(error) ? error : -1},
                       {"tolerance", limit},        {"of", tolerance.why},
                       {"numerics", all.numerics}};
    if (known) row["known"] = off;
    ::testing::Test::RecordProperty("validation_" + std::to_string(place->second.number), row.dump());
  }
  return known ? ::testing::AssertionSuccess() : within(residual, tolerance);
}

bool validating() { return std::getenv("PALP_VALIDATE") != nullptr; }

std::vector<Method> methods() {
  if (!validating()) return {Method::accurate};
  return {Method::accurate, Method::paper};
}

std::string quantity(double value, const std::string& unit) {
  char text[40];
  std::snprintf(text, sizeof text, "%.4g", value);
  return unit.empty() ? text : text + (" " + unit);
}

void computed_with(const std::string& numerics) { reports().numerics = numerics; }

}  // namespace palp::test
