// Everything that the viewer knows of the other processes. Pure: samples and times go in, no bus is needed.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "idl/bus.h"
#include "idl/frame_assembler.h"
#include "idl/particle_frame.h"
#include "idl/roster.h"
#include "idl/session_hold.h"
#include "viewer/frame_pool.h"

namespace palp {

// The newest of everything. All that servers say is of one of them, the one that is held (session_hold.h).
struct FeedView {
  std::shared_ptr<const SceneDescription> scene;  // null: none has arrived
  std::shared_ptr<const ParticleFrame> frame;     // newest complete one; null: none since the scene
  std::shared_ptr<const ParticleFrame> earlier;   // one a little before it in simulated time, or null
  std::int64_t frame_time_ns = 0;                 // CLOCK_MONOTONIC here: when it was sent (same host) or received
  std::shared_ptr<const BodyPoses> poses;
  std::array<std::optional<ProxySample>, kMaxDevices> proxies;
  std::map<std::string, Status> status;  // by process
  std::string notice;                    // the server's last refusal of a command or fault, while it is news
  std::string two_servers;               // which server is shown and which is passed over; empty where there is one
  // The server's newest replies to get_parameter, by the name that it was asked by; "": the list of its parameters.
  std::map<std::string, std::shared_ptr<const std::string>> told;
  std::string refusal;              // the server's answer to the newest command, where that was refused
  std::uint64_t answers = 0;        // of the server to commands of this viewer, questions aside
  std::uint64_t frames = 0;         // complete ones received
  std::uint64_t shared_frames = 0;  // of these, by shared memory
  std::string way;                  // by which they come: "shared memory" or "bus"; empty while there is none
  std::uint64_t lost_frames = 0;    // frames that never became complete
  std::uint64_t refused = 0;        // samples that were malformed or of another protocol version

  // Returns what was told of a name; null: nothing yet.
  std::shared_ptr<const std::string> told_of(const std::string& name) const {
    const auto entry = told.find(name);
    return entry == told.end() ? nullptr : entry->second;
  }
};

// Times are of this host's CLOCK_MONOTONIC [ns]. One thread.
class FeedState {
 public:
  // same_host: senders' clocks are this host's, so the age of a frame counts from when it was sent. own_session: whose
  // commands' replies matter.
  FeedState(bool same_host, std::uint64_t own_session) : same_host_(same_host), own_session_(own_session) {}

  // Another scene of the server that is held, or of the next one, drops all that is known of the one before. Frames may
  // arrive before their scene does.
  void add(const Received<SceneDescription>& received);
  void add(const Received<ParticleChunk>& received);
  // A whole frame that came by shared memory; its session and both times are filled in.
  void add(std::shared_ptr<const ParticleFrame> frame);
  void add(const Received<BodyPoses>& received);
  void add(const Received<ProxySample>& received);
  void add(const Received<Status>& received);
  void add(const Received<Event>& received);
  void add(const Received<CommandReply>& received);
  // Takes note that the newest command of ours that asks for this name has this sequence.
  void expect(const std::string& name, std::uint64_t sequence) { asked_[name] = sequence; }
  // Returns a frame to fill, for add.
  std::shared_ptr<ParticleFrame> spare_frame() { return pool_.take(); }
  void come_by(const std::string& way) { view_.way = way; }
  // Counts a frame that was refused before it got here.
  void count_refused() { ++view_.refused; }
  // Forgets what is too old to be believed: forces after 1 s, figures after 3 s, notices after 6 s.
  void forget(std::int64_t now_ns);

  const FeedView& view() const { return view_; }

 private:
  bool from_server(const Header& header) const;
  bool holds(const Header& header, std::int64_t now_ns);
  void go_over(std::uint64_t session, std::int64_t now_ns);
  void take_scene(std::shared_ptr<const SceneDescription> scene);
  bool show_frame();
  void notice(const std::string& text, std::int64_t now_ns);

  bool same_host_;
  std::uint64_t own_session_;
  FeedView view_;
  SessionHold servers_{kViewHold};
  Roster roster_;
  std::map<std::uint64_t, std::shared_ptr<const SceneDescription>> scenes_;  // newest of each server, by session
  FrameAssembler assembler_;
  FramePool pool_;
  std::shared_ptr<const ParticleFrame> newest_;  // perhaps of a server whose scene has not arrived
  std::array<std::int64_t, kMaxDevices> proxy_at_ns_{};
  std::map<std::string, std::int64_t> status_at_ns_;
  std::int64_t notice_at_ns_ = 0;
  std::map<std::string, std::uint64_t> asked_;  // by name, the sequence of the newest command that asks for it
};

}  // namespace palp
