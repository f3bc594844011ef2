// A small system that says something on every topic, in place of palp's processes.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "idl/bus.h"

namespace palp::test {

inline BusOptions on(Vendor vendor, int domain) {
  BusOptions options;
  options.vendor = vendor;
  options.domain = domain;
  return options;
}

// Speaks with one vendor on some topics and with the other on the rest.
class Talker {
 public:
  explicit Talker(int domain)
      : cyclone_(open_bus(on(Vendor::cyclone, domain))),
        fastdds_(open_bus(on(Vendor::fastdds, domain))),
        device_(fastdds_->writer<DeviceSample>()),
        proxy_(cyclone_->writer<ProxySample>()),
        particles_(fastdds_->writer<ParticleChunk>()),
        scene_(cyclone_->writer<SceneDescription>()),
        status_(fastdds_->writer<Status>()),
        event_(cyclone_->writer<Event>()) {
    scene_message_.name = "a tray";
    scene_message_.method = "accurate";
    scene_message_.particle_count = 6000;
    scene_message_.spacing = 0.005;
    scene_message_.support_radius = 0.01;
    scene_message_.haptic_rate_hz = 1000;
    BodyDescription& water = scene_message_.bodies.emplace_back();
    water.name = "water";
    water.count = 6000;
    water.density = 1000;
    water.color = {0, 0, 1};
    scene_->publish(scene_message_);
  }

  bool heard_chosen() const { return particles_->matched_readers() > 0 && proxy_->matched_readers() > 0; }
  bool heard() const {
    return device_->matched_readers() > 0 && proxy_->matched_readers() > 0 && particles_->matched_readers() > 0 &&
           scene_->matched_readers() > 0 && status_->matched_readers() > 0 && event_->matched_readers() > 0;
  }

  // One haptic step of 2 ms.
  void say(int step) {
    DeviceSample device;
    device.device = static_cast<std::uint32_t>(step % 2);
    device.pose.position = {0.25, -0.5, step * 0.125};
    device_->publish(device);
    ++said_["palp/device"];
    ProxySample proxy;
    proxy.device = static_cast<std::uint32_t>(step % 2);
    proxy.sim_time = step * 0.001;
    proxy.wrench.force = {1.5, step * 0.5, -3};
    proxy_->publish(proxy);
    ++said_["palp/proxy"];
    if (step % 20 == 0) say_frame(static_cast<std::uint64_t>(step) / 20);
    if (step % 100 == 0) {
      Status status;
      status.process = step % 200 == 0 ? "sim_server" : "viewer";
      status.state = "running";
      status.metrics = {{"step_p50_us", 250.5}};
      status_->publish(status);
      ++said_["palp/status"];
      Event event;
      event.process = "sim_server";
      event.text = "step " + std::to_string(step);
      event_->publish(event);
      ++said_["palp/event"];
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }

  const std::map<std::string, std::size_t>& said() const { return said_; }

 private:
  void say_frame(std::uint64_t frame) {
    for (std::uint32_t c = 0; c < 2; ++c) {
      ParticleChunk chunk;
      chunk.frame = frame;
      chunk.chunk = c;
      chunk.chunk_count = 2;
      chunk.first = c * 3000;
      chunk.particle_count = 6000;
      chunk.positions.assign(9000, 0.001f * static_cast<float>(frame));
      particles_->publish(chunk);
      ++said_["palp/particles"];
    }
  }

  std::unique_ptr<Bus> cyclone_;
  std::unique_ptr<Bus> fastdds_;
  std::unique_ptr<Writer<DeviceSample>> device_;
  std::unique_ptr<Writer<ProxySample>> proxy_;
  std::unique_ptr<Writer<ParticleChunk>> particles_;
  std::unique_ptr<Writer<SceneDescription>> scene_;
  std::unique_ptr<Writer<Status>> status_;
  std::unique_ptr<Writer<Event>> event_;
  SceneDescription scene_message_;
  std::map<std::string, std::size_t> said_{{"palp/scene", 1}};
};

}  // namespace palp::test
