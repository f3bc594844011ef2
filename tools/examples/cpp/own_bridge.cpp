// A bridge of one's own: plays a device that moves up and down, and prints the wrench that a hand would feel.
// Usage: own_bridge [SECONDS [DOMAIN]], beside palp-sim-server.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

#include "idl/bus.h"
#include "idl/clock.h"

namespace {

// The pose at which the scene's first tool waits for a hand.
palp::ProxyDescription first_tool(palp::Bus& bus) {
  const auto scenes = bus.reader<palp::SceneDescription>();
  for (palp::Received<palp::SceneDescription> scene;; scenes->wait(std::chrono::milliseconds(100)))
    if (scenes->take_latest(scene) && !scene.message.proxies.empty()) return scene.message.proxies.front();
}

void play_device(double seconds, int domain) {
  palp::BusOptions options;
  options.domain = domain;
  const auto bus = palp::open_bus(options);
  const auto devices = bus->writer<palp::DeviceSample>();
  const auto proxies = bus->reader<palp::ProxySample>();
  const palp::ProxyDescription tool = first_tool(*bus);

  palp::DeviceSample device;
  device.device = tool.device;
  device.flags = palp::kEngaged | palp::kHealthy;
  device.pose = tool.pose;
  device.gains = {300, 2, 3, 0.02};  // N/m, N s/m, N m/rad, N m s/rad
  palp::Received<palp::ProxySample> proxy;
  auto tick = std::chrono::steady_clock::now();
  for (int i = 0; i < 1000 * seconds; ++i) {
    std::this_thread::sleep_until(tick += std::chrono::milliseconds(1));
    const double t = 0.001 * i, amplitude = 0.01, rate = 2 * M_PI * 0.5;  // s, m, rad/s
    device.pose.position[2] = tool.pose.position[2] - amplitude * (1 - std::cos(rate * t));
    device.twist.linear[2] = -amplitude * rate * std::sin(rate * t);
    device.t_device_ns = palp::now_ns();
    devices->publish(device);
    proxies->take_latest(proxy);
    if (i % 100 == 99) {
      const auto& [force, torque] = proxy.message.wrench;
      std::printf("%.1f s: force %.3f %.3f %.3f N, torque %.4f %.4f %.4f N m\n", t, force[0], force[1], force[2],
                  torque[0], torque[1], torque[2]);
    }
  }
}

}  // namespace

int main(int argc, char** argv) try {
  play_device(argc > 1 ? std::atof(argv[1]) : 10, argc > 2 ? std::atoi(argv[2]) : 0);
} catch (const std::exception& error) {
  std::fprintf(stderr, "own_bridge: %s\n", error.what());
  return 1;
}
