// The three processes found each other: whichever starts first, whichever vendor each of them speaks.
#include "tests/process/running_system.h"

namespace palp::test::start_order_test {
namespace {

// order: s server, b bridge, v viewer.
struct Row {
  std::string order;
  Vendor server, bridge, viewer;
};

void PrintTo(const Row& row, std::ostream* out) {
  *out << row.order << ", server " << to_string(row.server) << ", bridge " << to_string(row.bridge) << ", viewer "
       << to_string(row.viewer);
}

class StartOrder : public RunningSystem, public testing::WithParamInterface<Row> {};

TEST_P(StartOrder, EveryOneIsHealthyAndForceIsFelt) {
  const Row& row = GetParam();
  for (const char who : row.order) {
    if (who == 's') start_server(row.server);
    if (who == 'b') start_bridge(row.bridge);
    if (who == 'v') start_viewer(row.viewer);
    std::this_thread::sleep_for(300ms);  // it shall be there before the next one begins
  }
  Watcher& watcher = watch(row.viewer);
  EXPECT_TRUE(force_is_felt(watcher)) << said();
  EXPECT_TRUE(viewer_draws(watcher)) << said();
  // they are stopped in the order in which they came, too
  for (const char who : row.order) {
    if (who == 's') stop_server();
    if (who == 'b') stop_bridge();
    if (who == 'v') stop_viewer();
  }
  EXPECT_EQ(number_in_json(summary("palp-sim-server"), "dropped_samples"), 0) << summary("palp-sim-server");
}

// Every order, every pairing of server and bridge, a viewer of the other vendor.
constexpr Vendor kC = Vendor::cyclone, kF = Vendor::fastdds;
INSTANTIATE_TEST_SUITE_P(Orders, StartOrder,
                         testing::Values(Row{"sbv", kC, kC, kF}, Row{"svb", kC, kF, kF}, Row{"bsv", kF, kC, kC},
                                         Row{"bvs", kF, kF, kC}, Row{"vsb", kC, kC, kC}, Row{"vbs", kC, kF, kF}),
                         [](const auto& of) {
                           const Row& r = of.param;
                           return r.order + "_" + to_string(r.server) + "_" + to_string(r.bridge) + "_" +
                                  to_string(r.viewer);
                         });

}  // namespace
}  // namespace palp::test::start_order_test
