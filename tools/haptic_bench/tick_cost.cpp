#include "tools/haptic_bench/tick_cost.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>

#include <fmt/format.h>
#include <unistd.h>

#include "haptic_bridge/device/replay.h"
#include "haptic_bridge/device/virtuose.h"
#include "haptic_bridge/run.h"
#include "tools/haptic_bench/series.h"
#include "tools/haptic_bench/system.h"

namespace palp::bench {

namespace {

constexpr double kWallStiffness = 5000;  // [N/m]
constexpr double kWanted = 20;           // most CPU time a tick [us]

double cpu_us() { return 1e-3 * static_cast<double>(RealClock().cpu_ns()); }

// Does nothing and is held.
class NoDevice final : public HapticDevice {
 public:
  const DeviceInfo& info() const noexcept override { return info_; }
  bool read(std::int64_t now_ns, DeviceReading& out) noexcept override {
    out.state = at_rest({0, 0, -1e-3}, Eigen::Quaterniond::Identity());
    out.dead_man = grip_.holds(now_ns);
    out.powered = out.chain_closed = true;
    return true;
  }
  bool write(const Wrench<double>&) noexcept override { return true; }
  void show(LoopState state) noexcept override { grip_.show(state); }

 private:
  Grip grip_;
  DeviceInfo info_{"none", 35, 3, true};
};

// Instead of sleeping it notes what the tick before has cost and plays the server.
class CostClock final : public Clock {
 public:
  CostClock(LoopPorts& ports, std::size_t ticks) : ports_(ports) { costs_.reserve(ticks); }
  std::int64_t now_ns() noexcept override { return now_; }
  void sleep_until(std::int64_t t_ns) noexcept override {
    if (began_ > 0) costs_.push_back(cpu_us() - began_);
    now_ = t_ns;
    serve();
    began_ = cpu_us();
  }
  const Series& costs() const { return costs_; }

 private:
  // A wall at the place where the tool was first, that gives way and is a little rough.
  void serve() {
    DeviceSample device;
    if (!ports_.outgoing.take(device)) return;
    if (++sequence_ == 1) height_ = device.pose.position[2] + 2e-3;
    const double k = device.gains.stiffness, share = kWallStiffness / (k + kWallStiffness);
    const double depth = height_ - device.pose.position[2] + (sequence_ % 2 == 0 ? 1e-5 : -1e-5);
    ProxySample s;
    s.header = {kProtocolVersion, kServerSession, sequence_, now_};
    s.flags = kEngaged | kHealthy;
    s.sim_time = 1e-3 * static_cast<double>(sequence_);
    s.device_session = kBridgeSession;
    s.device_sequence = sequence_;
    s.t_device_ns = device.t_device_ns;
    s.device_pose = s.proxy_pose = device.pose;
    s.device_twist = device.twist;
    s.gains = device.gains;
    s.blend = {share, share};
    s.proxy_pose.position[2] += share * depth;
    s.wrench.force[2] = k * share * depth;
    s.energy = {1e-6 * static_cast<double>(sequence_ % 100), 0};
    ports_.incoming.put({s, now_});
  }

  LoopPorts& ports_;
  Series costs_;
  std::int64_t now_ = 1'000'000'000;
  std::uint64_t sequence_ = 0;
  double height_ = 0, began_ = 0;
};

TickCost cost_with(const std::string& name, const DeviceProfile& profile, HapticDevice& device, std::size_t ticks) {
  LoopConfig config = profile.loop;
  config.own_session = kBridgeSession;
  config.workspace = {2, 0.5, true};
  config.limits.axis_force.setConstant(config.limits.force);
  config.limits.axis_torque.setConstant(config.limits.torque);
  config.limits.continuous_force = config.limits.force / 2;
  config.limits.continuous_torque = config.limits.torque / 2;
  HapticLoop loop(config, device);
  const auto ports = std::make_unique<LoopPorts>();
  FlightLog log(60'000);
  CostClock clock(*ports, ticks);
  const std::atomic<bool> stop{false};
  const LoopFault fault = run_loop(loop, clock, *ports, log, stop, ticks + 1);
  if (fault != LoopFault::none) throw std::runtime_error(name + ": " + to_string(fault) + " " + device.trouble());
  double felt = 0;
  for (std::size_t i = 0; i < log.size(); ++i) felt += log.at(i).engagement > 0;
  const Series& c = clock.costs();
  const auto over = std::count_if(c.begin(), c.end(), [](double us) { return us > kWanted; });
  return {name,
          c.size(),
          quantile(c, 0.5),
          quantile(c, 0.99),
          quantile(c, 1),
          static_cast<std::size_t>(over),
          felt / static_cast<double>(log.size())};
}

// Files for as long as the measurement lasts.
class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / fmt::format("palp_tick_cost_{}", getpid())) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string with(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return (path_ / name).string();
  }

 private:
  std::filesystem::path path_;
};

}  // namespace

std::vector<TickCost> tick_costs(const DeviceProfile& profile, const std::string& virtuose_library, std::size_t ticks) {
  const Folder folder;
  const RigidState start = at_rest({0, 0, 0}, Eigen::Quaterniond::Identity());
  HandScript hand;
  hand.keyframes = {{0, {0, 0, 0}}, {1, {0, 0, -0.002}}, {2, {0.005, 0, 0}}, {3, {0, 0, 0}}};
  hand.loop = true;
  std::vector<TickCost> costs;
  NoDevice none;
  costs.push_back(cost_with("none: the loop alone", profile, none, ticks));
  SimulatedDevice arm(profile.setup<ArmModel>(), hand, start, start);
  costs.push_back(cost_with("simulated arm and hand", profile, arm, ticks));
  ReplayDevice replay(folder.with("path.csv",
                                  "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n1,0,0,-0.002,0,0,0,1\n"
                                  "2,0.005,0,0,0,0,0,1\n3,0,0,0,0,0,0,1\n"),
                      true);
  costs.push_back(cost_with("replayed path", profile, replay, ticks));
  VirtuoseSetup setup = profile.setup<VirtuoseSetup>();
  setup.library = virtuose_library;
  setup.address = folder.with("arm.toml", "clock = \"lock_step\"\ngrip_at = 0.1\nrelay_delay = 0\n");
  setup.relay_time = 0.05;
  setup.limits = profile.loop.limits;
  VirtuoseDevice virtuose(setup, start);
  costs.push_back(cost_with("simulated Virtuose behind its driver", profile, virtuose, ticks));
  return costs;
}

std::string markdown(const std::vector<TickCost>& costs) {
  std::string text = fmt::format(
      "| device | ticks | with force | median | 99 % | most | above {0:g} us |\n|---|---|---|---|---|---|---|\n",
      kWanted);
  for (const TickCost& c : costs)
    text += fmt::format("| {} | {} | {:.0f} % | {:.2f} us | {:.2f} us | {:.1f} us | {} |\n", c.device, c.ticks,
                        100 * c.share_felt, c.median_us, c.p99_us, c.max_us, c.over);
  return text;
}

}  // namespace palp::bench
