// What the viewer knows of the other processes: a thread takes the newest of every topic from the bus and keeps it
// until the thread that draws asks. The readers are best effort and keep nothing back, so a slow or stopped viewer
// costs the others nothing.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "idl/bus.h"
#include "viewer/particle_cloud.h"

namespace palp {

// The newest of everything. All but status belongs to one server, the one whose scene arrived last.
struct FeedView {
  std::shared_ptr<const SceneDescription> scene;  // null: none has arrived
  std::shared_ptr<const ParticleFrame> frame;     // newest complete one; null: none since the scene
  std::int64_t frame_time_ns = 0;                 // CLOCK_MONOTONIC here: when it was sent (same host) or received
  std::shared_ptr<const BodyPoses> poses;
  std::array<std::optional<ProxySample>, kMaxDevices> proxies;
  std::map<std::string, Status> status;  // by process
  std::string reply;                     // the server's refusal of the last command, or its last fault
  std::uint64_t frames = 0;              // complete ones received
  std::uint64_t lost_frames = 0;         // frames that never became complete
  std::uint64_t refused = 0;             // samples that were malformed or of another protocol version
};

class Feed {
 public:
  // Opens the bus and starts the thread. Throws std::runtime_error as open_bus does.
  explicit Feed(const BusOptions& options);
  ~Feed();

  // Any thread. Copies shared pointers and small structs only.
  FeedView view() const;
  // Any thread; the feed's own thread sends it.
  void send(CommandKind kind, const std::string& name = "", const std::string& value = "");
  // Any thread; published as the viewer's Status.
  void report(const std::string& state, std::vector<Metric> metrics);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palp
