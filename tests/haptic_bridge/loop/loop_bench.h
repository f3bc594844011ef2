// A loop on a puppet, with a server that answers each tick: for tests of what the loop does with either.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>

#include "tests/haptic_bridge/loop/fake_server.h"

namespace palp::test {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kRounding = 1e-9;  // [N]

inline LoopConfig config_for_tests() {
  LoopConfig config;
  config.own_session = kBridgeSession;
  config.limits = {8, 0.5, 300, 30};
  return config;
}

// A loop, a puppet and a server that answers each tick with a constant force, one tick later.
struct Bench {
  explicit Bench(const LoopConfig& config = config_for_tests()) : loop(config, device) {}

  ProxySample next_answer() {
    ProxySample s = answer(loop.sample(), session, ++sequence);
    s.wrench.force = force;
    if (lie) lie(s);
    return s;
  }
  void tick(bool with_sample = true) {
    now += kMillisecond;
    if (with_sample && loop.report().ticks > 0) {
      const IncomingProxy in{next_answer(), now};
      loop.tick(now, 0, 0, &in);
    } else {
      loop.tick(now, 0, 0, nullptr);
    }
  }
  void ticks(int n, bool with_sample = true) {
    for (int i = 0; i < n; ++i) tick(with_sample);
  }
  void engage() { ticks(1000); }
  double felt() const { return device.written.force.norm(); }
  std::uint64_t count(Verdict v) const { return loop.report().verdicts[static_cast<std::size_t>(v)]; }

  PuppetDevice device;
  HapticLoop loop;
  std::int64_t now = 1'000'000'000;
  std::uint64_t session = 5;
  std::uint64_t sequence = 0;
  std::array<double, 3> force{0, 0, 4};
  std::function<void(ProxySample&)> lie;
};

}  // namespace palp::test
