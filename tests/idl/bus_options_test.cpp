// Options of the bus as a command line gives them.
#include "idl/bus_options.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace palp::test::bus_options_test {
namespace {

BusOptions parse(std::vector<std::string> arguments) {
  CLI::App app;
  BusOptions options;
  add_bus_options(app, options);
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  return options;
}

TEST(BusOptions, ComeFromTheCommandLine) {
  const BusOptions defaults = parse({});
  EXPECT_EQ(defaults.vendor, Vendor::cyclone);
  EXPECT_EQ(defaults.domain, 0);
  EXPECT_FALSE(defaults.network);
  const BusOptions o = parse({"--dds", "fastdds", "--domain", "7", "--network", "--interface", "eth0", "--peer",
                              "10.0.0.2", "--peer", "10.0.0.3"});
  EXPECT_EQ(o.vendor, Vendor::fastdds);
  EXPECT_EQ(o.domain, 7);
  EXPECT_TRUE(o.network);
  EXPECT_EQ(o.interface, "eth0");
  EXPECT_EQ(o.peers, (std::vector<std::string>{"10.0.0.2", "10.0.0.3"}));
  EXPECT_THROW(parse({"--dds", "other"}), CLI::ParseError);
  EXPECT_THROW(parse({"--domain", "233"}), CLI::ParseError);
  EXPECT_THROW(parse({"--domain", "-1"}), CLI::ParseError);
}

TEST(BusOptions, NameTheVendors) {
  for (const Vendor v : {Vendor::cyclone, Vendor::fastdds}) EXPECT_EQ(vendor_from(to_string(v)), v);
  EXPECT_THROW(vendor_from("Cyclone "), std::invalid_argument);
}

}  // namespace
}  // namespace palp::test::bus_options_test
