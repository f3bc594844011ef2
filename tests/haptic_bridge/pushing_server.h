// A server on the bus for a real bridge: it answers each device state with the same push.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <thread>

#include "idl/bus.h"
#include "idl/clock.h"

namespace palp::test {

// A server that pushes the device up with a constant force, as long as it lives.
class PushingServer {
 public:
  PushingServer(const BusOptions& options, std::uint32_t proxy_device = 0) : bus_(open_bus(options)) {
    scene_ = bus_->writer<SceneDescription>();
    SceneDescription scene;
    scene.name = "test";
    scene.method = "accurate";
    scene.particle_count = 0;
    scene.spacing = 0.01;
    scene.support_radius = 0.02;
    scene.haptic_rate_hz = 1000;
    scene.bodies.emplace_back();
    scene.bodies[0].name = "tool";
    scene.bodies[0].kind = BodyKind::rigid;
    ProxyDescription proxy;
    proxy.device = proxy_device;
    proxy.pose.position = {0.1, 0.2, 0.3};
    scene.proxies.push_back(proxy);
    scene_->publish(scene);
    thread_ = std::thread([this] { serve(); });
  }
  ~PushingServer() {
    stop_ = true;
    thread_.join();
  }
  std::uint64_t heard() const { return heard_; }
  std::int64_t t_last_sent_ns() const { return t_last_sent_ns_; }

 private:
  void serve() {
    const auto reader = bus_->reader<DeviceSample>();
    const auto writer = bus_->writer<ProxySample>();
    Received<DeviceSample> in;
    while (!stop_) {
      if (!reader->wait(std::chrono::milliseconds(10)) || !reader->take_latest(in)) continue;
      ++heard_;
      const DeviceSample& d = in.message;
      ProxySample s;
      s.device = d.device;
      s.flags = kEngaged | kHealthy;
      s.device_session = d.header.session;
      s.device_sequence = d.header.sequence;
      s.t_device_ns = d.t_device_ns;
      s.device_pose = s.proxy_pose = d.pose;
      s.device_twist = s.proxy_twist = d.twist;
      s.gains = d.gains;
      s.wrench.force = {0, 0, 3};
      writer->publish(s);
      t_last_sent_ns_ = now_ns();
    }
  }

  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Writer<SceneDescription>> scene_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> heard_{0};
  std::atomic<std::int64_t> t_last_sent_ns_{0};
};

}  // namespace palp::test
