// Tests what people give the bus: options, and the vendors' own configuration.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "idl/bus.h"
#include "tests/support/bus.h"
#include "tests/support/valid_messages.h"

namespace palp::test::bus_config_test {
namespace {

// Sets an environment variable for the life of this object.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) { setenv(name, value.c_str(), 1); }
  ~Environment() { unsetenv(name_); }

 private:
  const char* name_;
};

std::string file_with(const std::string& name, const std::string& text) {
  const auto path = std::filesystem::temp_directory_path() / ("palp_" + std::to_string(getpid()) + "_" + name);
  std::ofstream(path) << text;
  return path.string();
}

// Returns the sentence that open_bus throws, or "" if it does not.
std::string refusal(const BusOptions& options) {
  try {
    open_bus(options);
    return "";
  } catch (const std::runtime_error& e) {
    return e.what();
  }
}

void expect_refused(const BusOptions& options, const std::string& part) {
  const std::string text = refusal(options);
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << text << "\"";
  EXPECT_EQ(text.find('\n'), std::string::npos);
}

class BusConfig : public testing::TestWithParam<Vendor> {};

TEST_P(BusConfig, RefusesOptionsThatCannotBe) {
  BusOptions o = options_for(GetParam());
  o.domain = 233;
  expect_refused(o, "domain 233");
  o = options_for(GetParam());
  o.peers = {"1.2.3.4\"/><x"};
  expect_refused(o, "peer");
  o.peers = {""};
  expect_refused(o, "peer");
  o = options_for(GetParam());
  o.interface = "lo";
  expect_refused(o, "--network");
  o.network = true;
  o.interface = "no<such>";
  expect_refused(o, "interface");
  o.interface = "nosuchinterface0";
  expect_refused(o, GetParam() == Vendor::cyclone ? "Cyclone DDS" : "nosuchinterface0");
}

TEST_P(BusConfig, RefusesAVendorConfigurationThatIsMissingOrMalformed) {
  const bool cyclone = GetParam() == Vendor::cyclone;
  const char* name = cyclone ? "CYCLONEDDS_URI" : "FASTRTPS_DEFAULT_PROFILES_FILE";
  const std::string scheme = cyclone ? "file://" : "";
  {
    const Environment e(name, scheme + "/nonexistent/dds.xml");
    expect_refused(options_for(GetParam()), name);
  }
  for (const char* text : {"", "this is no XML", "<CycloneDDS><Domain>", "<dds><profiles><participant",
                           "<CycloneDDS><Domain><Nonsense>1</Nonsense></Domain></CycloneDDS>"}) {
    const std::string path = file_with("bad.xml", text);
    const Environment e(name, scheme + path);
    expect_refused(options_for(GetParam()), name);
    std::filesystem::remove(path);
  }
  EXPECT_EQ(refusal(options_for(GetParam())), "") << "and works again without it";
}

TEST_P(BusConfig, UsesTheVendorConfigurationOfTheUser) {
  const bool cyclone = GetParam() == Vendor::cyclone;
  const std::string good =
      cyclone ? R"(<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo" multicast="false"/>
        </Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
        <Peers><Peer Address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>)"
              : R"(<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles"><profiles>
        <transport_descriptors><transport_descriptor><transport_id>lo</transport_id><type>UDPv4</type>
        <interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList></transport_descriptor></transport_descriptors>
        <participant profile_name="p" is_default_profile="true"><rtps><useBuiltinTransports>false</useBuiltinTransports>
        <userTransports><transport_id>lo</transport_id></userTransports><builtin>
        <avoid_builtin_multicast>true</avoid_builtin_multicast>
        <metatrafficUnicastLocatorList><locator/></metatrafficUnicastLocatorList>
        <initialPeersList><locator><udpv4><address>127.0.0.1</address></udpv4></locator></initialPeersList>
        </builtin></rtps></participant></profiles></dds>)";
  const std::string path = file_with("good.xml", good);
  const Environment e(cyclone ? "CYCLONEDDS_URI" : "FASTRTPS_DEFAULT_PROFILES_FILE", (cyclone ? "file://" : "") + path);
  const auto out = open_bus(options_for(GetParam()));
  const auto in = open_bus(options_for(GetParam()));
  const auto writer = out->writer<Event>();
  const auto reader = in->reader<Event>();
  auto m = sound<Event>();
  writer->publish(m);
  Received<Event> got;
  EXPECT_TRUE(eventually([&] { return (reader->wait(10ms), reader->take_latest(got)); }));
  std::filesystem::remove(path);
}

INSTANTIATE_TEST_SUITE_P(Vendors, BusConfig, testing::Values(Vendor::cyclone, Vendor::fastdds),
                         [](const auto& i) { return std::string(to_string(i.param)); });

}  // namespace
}  // namespace palp::test::bus_config_test
