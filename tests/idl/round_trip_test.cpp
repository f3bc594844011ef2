// Every field of every message survives the wire, from each vendor to each.
#include <gtest/gtest.h>

#include "tests/idl/reflect.h"
#include "tests/support/bus.h"

namespace palp::test::round_trip_test {
namespace {

class RoundTrip : public testing::TestWithParam<Pairing> {
 protected:
  template <class T>
  void check(const std::shared_ptr<Participant>& from, const std::shared_ptr<Participant>& to) {
    SCOPED_TRACE(topic_of<T>().name);
    auto sink = raw_sink<T>(std::get<0>(GetParam()), from);
    auto source = raw_source<T>(std::get<1>(GetParam()), to);
    ASSERT_TRUE(eventually([&] { return sink->matched() > 0 && source->matched() > 0; }));

    T sent;
    Fill fill;
    fill(sent);
    std::vector<Taken<T>> taken;
    // best effort may lose one
    ASSERT_TRUE(eventually([&] {
      EXPECT_TRUE(sink->write(sent));
      source->wait(20ms);
      return source->take(taken, 0) > 0;
    }));
    Differences differences;
    differences(sent, taken[0].message);
    EXPECT_EQ(differences.count, 0);

    // the filler and the comparison must be able to see a difference
    Differences all;
    all(sent, T{});
    EXPECT_GE(all.count, 5);
  }
};

TEST_P(RoundTrip, KeepsEveryFieldOfEveryMessage) {
  const auto from = open_raw(std::get<0>(GetParam()));
  const auto to = open_raw(std::get<1>(GetParam()));
#define PALP_CHECK(T) check<T>(from, to);
  PALP_FOR_EACH_MESSAGE(PALP_CHECK)
#undef PALP_CHECK
}

INSTANTIATE_TEST_SUITE_P(Vendors, RoundTrip,
                         testing::Combine(testing::Values(Vendor::cyclone, Vendor::fastdds),
                                          testing::Values(Vendor::cyclone, Vendor::fastdds)),
                         pairing_name<testing::TestParamInfo<Pairing>>);

}  // namespace
}  // namespace palp::test::round_trip_test
