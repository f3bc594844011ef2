// Tests that what the bus brings is not trusted: samples that are of another version, not finite or otherwise wrong are
// counted and dropped by the server and by the bridge, and never become a force. They are sent below the checks of the
// bus.
#include <cmath>
#include <limits>

#include "idl/mcap/mcap_format.h"
#include "idl/vendor.h"
#include "tests/process/running_system.h"
#include "tests/support/valid_messages.h"
#include "tools/recording/raw_bus.h"

namespace palp::test::bad_peers_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

constexpr std::uint32_t kOtherVersion = kProtocolVersion + 6;

std::string of_another_version(const std::string& topic) {
  return "protocol version " + std::to_string(kOtherVersion) + " on " + topic;
}

template <class T>
struct Fault {
  const char* name;
  std::function<void(T&)> spoil;
};

class BadPeers : public RunningSystem, public testing::WithParamInterface<Vendor> {
 protected:
  template <class T>
  std::unique_ptr<Sink<T>> raw_sink() const {
    return GetParam() == Vendor::cyclone ? cyclone_sink<T>(open_cyclone(on(GetParam())))
                                         : fastdds_sink<T>(open_fastdds(on(GetParam())));
  }
  // Sends the sample again and again until the process says that it refused more of them than before.
  bool refused(Watcher& watcher, const std::string& process, const std::function<void()>& send) {
    watcher.hears_news_of(process);  // what was sent before is counted by then
    const double before = watcher.metric(process, "dropped_samples");
    return watcher.sees([&] { return (send(), watcher.metric(process, "dropped_samples") > before); });
  }
  // Sends bytes that are no sample: cut off after the key.
  template <class T>
  bool refuses_fragments(Watcher& watcher, const std::string& process) {
    const auto bus = open_raw_bus(on(GetParam()));
    const auto writer = bus->writer(topic_of<T>());
    EXPECT_TRUE(eventually([&] { return writer->matched_readers() > 0; }, kPatience));
    const Bytes fragment{0, 1, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff};
    return refused(watcher, process, [&] { writer->write(fragment); });
  }
};

TEST_P(BadPeers, TheServerDropsBadDeviceSamplesAndEngagesOnNone) {
  Watcher& watcher = watch();
  start_server();
  const auto sink = raw_sink<DeviceSample>();
  ASSERT_TRUE(watcher.sees([&] { return sink->matched() > 0 && watcher.says("sim_server", "running"); })) << said();
  const std::vector<Fault<DeviceSample>> faults{
      {"not a number", [](DeviceSample& s) { s.pose.position[1] = kNan; }},
      {"infinite speed", [](DeviceSample& s) { s.twist.angular[2] = kInf; }},
      {"infinite gain", [](DeviceSample& s) { s.gains.stiffness = kInf; }},
      {"no rotation",
       [](DeviceSample& s) {
         s.pose.orientation = {0, 0, 0, 0};
       }},
      {"no such device", [](DeviceSample& s) { s.device = kMaxDevices; }},
      {"another version", [](DeviceSample& s) { s.header.version = kOtherVersion; }},
  };
  std::uint64_t sequence = 0;
  for (const Fault<DeviceSample>& fault : faults) {
    SCOPED_TRACE(fault.name);
    EXPECT_TRUE(refused(watcher, "sim_server", [&] {
      auto sample = sound<DeviceSample>();
      sample.device = 0;
      sample.header.sequence = ++sequence;
      fault.spoil(sample);
      sink->write(sample);
    })) << said();
  }
  EXPECT_TRUE(watcher.sees([&] {
    return watcher.status["sim_server"].text.find(of_another_version("palp/device")) != std::string::npos;
  })) << watcher.status["sim_server"].text;
  EXPECT_TRUE(refuses_fragments<DeviceSample>(watcher, "sim_server")) << said();
  const double steps = watcher.metric("sim_server", "steps");
  EXPECT_TRUE(watcher.sees([&] { return watcher.metric("sim_server", "steps") > steps + 200; })) << said();
  EXPECT_GT(watcher.proxies_heard, 100u);
  EXPECT_EQ(watcher.engaged_heard, 0u);
  EXPECT_TRUE(watcher.says("sim_server", "running"));

  start_bridge();
  EXPECT_TRUE(force_is_felt(watcher)) << said();
  stop_bridge();
  stop_server();
  EXPECT_GE(number_in_json(summary("palp-sim-server"), "dropped_samples"), static_cast<double>(faults.size()));
}

// Returns a pull by a server that answers this very bridge.
ProxySample pull(const DeviceSample& d) {
  ProxySample s;
  s.header.session = 77;
  s.flags = kEngaged | kHealthy;
  s.device_session = d.header.session;
  s.device_sequence = d.header.sequence;
  s.t_device_ns = d.t_device_ns;
  s.device_pose = s.proxy_pose = d.pose;
  s.proxy_pose.position[2] += 0.002;
  s.gains = d.gains;
  s.wrench.force = {0, 0, 2};
  return s;
}

TEST_P(BadPeers, TheBridgeDropsBadProxySamplesAndRendersNoForce) {
  Watcher& watcher = watch();
  const auto devices = watcher.bus().reader<DeviceSample>();
  start_bridge(Vendor::cyclone, {"--home", "0", "0", "0.4"});
  const auto sink = raw_sink<ProxySample>();
  Received<DeviceSample> device;
  ASSERT_TRUE(watcher.sees([&] {
    return sink->matched() > 0 && watcher.says("haptic_bridge 0", "waiting") && devices->take_latest(device);
  })) << said();
  std::uint64_t sequence = 0;
  const auto send = [&](const std::function<void(ProxySample&)>& spoil) {
    devices->take_latest(device);
    ProxySample answer = pull(device.message);
    answer.header.sequence = ++sequence;
    spoil(answer);
    sink->write(answer);
  };
  const std::vector<Fault<ProxySample>> faults{
      {"force not a number", [](ProxySample& s) { s.wrench.force[2] = kNan; }},
      {"infinite place", [](ProxySample& s) { s.proxy_pose.position[0] = -kInf; }},
      {"no rotation",
       [](ProxySample& s) {
         s.proxy_pose.orientation = {0, 0, 0, 0};
       }},
      {"absurd force", [](ProxySample& s) { s.wrench.force[0] = 1e9; }},
      {"gains beyond those asked for", [](ProxySample& s) { s.gains.stiffness *= 10; }},
      {"an answer to the future", [](ProxySample& s) { s.t_device_ns += 3'600'000'000'000; }},
      {"another version", [](ProxySample& s) { s.header.version = kOtherVersion; }},
  };
  for (const Fault<ProxySample>& fault : faults) {
    SCOPED_TRACE(fault.name);
    EXPECT_TRUE(refused(watcher, "haptic_bridge 0", [&] { send(fault.spoil); })) << said();
  }
  EXPECT_TRUE(watcher.sees([&] {
    return watcher.status["haptic_bridge 0"].text.find(of_another_version("palp/proxy")) != std::string::npos;
  })) << watcher.status["haptic_bridge 0"].text;
  EXPECT_TRUE(refuses_fragments<ProxySample>(watcher, "haptic_bridge 0")) << said();
  const double ticks = watcher.metric("haptic_bridge 0", "ticks");
  EXPECT_TRUE(watcher.sees([&] { return watcher.metric("haptic_bridge 0", "ticks") > ticks + 200; })) << said();
  EXPECT_TRUE(watcher.says("haptic_bridge 0", "waiting")) << watcher.status["haptic_bridge 0"].state;
  EXPECT_EQ(watcher.metric("haptic_bridge 0", "peak_force_n"), 0);
  EXPECT_EQ(watcher.metric("haptic_bridge 0", "peak_torque_nm"), 0);

  // the same sample without a fault is felt
  EXPECT_TRUE(watcher.sees([&] {
    send([](ProxySample&) {});
    return watcher.metric("haptic_bridge 0", "force_n") > 0.5;
  })) << said();
  stop_bridge();
}

INSTANTIATE_TEST_SUITE_P(Senders, BadPeers, testing::Values(Vendor::cyclone, Vendor::fastdds),
                         [](const auto& of) { return std::string(to_string(of.param)); });

}  // namespace
}  // namespace palp::test::bad_peers_test
