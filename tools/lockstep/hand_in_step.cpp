#include "tools/lockstep/hand_in_step.h"

#include <cmath>

#include "config/data_dir.h"
#include "haptic_bridge/device/profile.h"
#include "haptic_bridge/device/simulated.h"
#include "haptic_bridge/loop/loop.h"
#include "sim_server/device_tracker.h"
#include "sim_server/messages_from_state.h"

namespace palp {
namespace {

constexpr std::int64_t kStartNs = 1'000'000'000;  // stamps must be above zero
constexpr std::uint64_t kBridgeSession = 1, kServerSession = 2;

std::int64_t to_ns(double seconds) { return kStartNs + std::llround(1e9 * seconds); }

DeviceProfile simulated_profile() { return read_device_profile(find_data_file(kDeviceProfiles, "simulated")); }

LoopConfig config_for(const DeviceProfile& profile, std::uint32_t device) {
  LoopConfig config = profile.loop;
  config.device = device;
  config.own_session = kBridgeSession;
  return config;
}

}  // namespace

struct HandInStep::Parts {
  Parts(std::uint32_t number, const DeviceProfile& profile, const HandScript& script, const RigidState& handle)
      : device(number),
        arm(profile.setup<ArmModel>(), script, handle, handle),
        loop(config_for(profile, number), arm) {}

  std::uint32_t device;
  SimulatedDevice arm;
  HapticLoop loop;
  DeviceTracker tracker;
  std::uint64_t sent = 0, answered = 0;
  std::int64_t next_tick_ns = kStartNs;
  IncomingProxy incoming;
  bool fresh = false;  // incoming was not taken in yet
};

HandInStep::HandInStep(std::uint32_t device, const std::string& script, const RigidState& handle)
    : parts_(std::make_unique<Parts>(device, simulated_profile(), read_hand_script(script), handle)) {}
HandInStep::~HandInStep() = default;
HandInStep::HandInStep(HandInStep&&) noexcept = default;
HandInStep& HandInStep::operator=(HandInStep&&) noexcept = default;

DeviceInput HandInStep::input(double time, double step, const RigidState& proxy) {
  Parts& p = *parts_;
  const std::int64_t now = to_ns(time);
  for (; p.next_tick_ns <= now; p.next_tick_ns += p.loop.config().period_ns) {
    p.loop.tick(p.next_tick_ns, 0, 0, p.fresh ? &p.incoming : nullptr);
    p.fresh = false;
    if (!p.loop.worth_sending()) continue;
    DeviceSample sample = p.loop.sample();
    sample.header = {kProtocolVersion, kBridgeSession, ++p.sent, p.next_tick_ns};
    p.tracker.receive(sample, p.next_tick_ns);
  }
  return p.tracker.input(now, step, proxy);
}

ProxySample HandInStep::answer(const ProxyOutput& proxy, bool ok, double time) {
  Parts& p = *parts_;
  ProxySample sample = make_proxy_sample(proxy, p.device, p.tracker.sample(), p.tracker.engaged(),
                                         ok ? ServerState::running : ServerState::fault, time);
  sample.header = {kProtocolVersion, kServerSession, ++p.answered, to_ns(time)};
  p.incoming = {};
  p.incoming.sample = sample;
  p.incoming.t_receive_ns = to_ns(time);
  p.fresh = true;
  return sample;
}

}  // namespace palp
