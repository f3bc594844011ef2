#include "viewer/playback.h"

#include <algorithm>
#include <cmath>

#include <spdlog/spdlog.h>

#include "idl/convert.h"
#include "viewer/frame_blend.h"
#include "viewer/medium.h"

namespace palp {
namespace {

constexpr std::int64_t kNoticeNs = 6'000'000'000;
// [s] of playing after which what was said counts no more, as FeedState has it
constexpr double kOldProxy = 1, kOldStatus = 3, kForgetEvent = 6;
constexpr std::size_t kMostRemarks = 5;
constexpr const char* kServer = "sim_server";

}  // namespace

Playback::Playback(const std::string& file) : recording_(file) {
  const RecordingIndex& index = recording_.index();
  range_ = {index.frames.front().time, index.frames.back().time};
  time_ = range_.first;
  for (std::size_t i = 0; i < std::min(kMostRemarks, index.remarks.size()); ++i) spdlog::warn("{}", index.remarks[i]);
  if (index.remarks.size() > kMostRemarks)
    spdlog::warn("{}: {} more faults", file, index.remarks.size() - kMostRemarks);
  if (!index.remarks.empty()) spdlog::warn("{}: what can be read of it is shown", file);
  spdlog::info("{}: {} frames from {:.3f} to {:.3f} s of simulated time", file, index.frames.size(), range_.first,
               range_.last);
}

void Playback::seek(double time) {
  if (std::isfinite(time)) time_ = std::clamp(time, range_.first, range_.last);
}

void Playback::step(int frames) {
  const auto& all = recording_.index().frames;
  const auto at = static_cast<std::ptrdiff_t>(recording_.frame_at(time_));
  // back from between two frames goes to the first of them
  const bool between = all[static_cast<std::size_t>(at)].time < time_;
  const std::ptrdiff_t to = std::clamp<std::ptrdiff_t>(at + frames + (frames < 0 && between ? 1 : 0), 0,
                                                       static_cast<std::ptrdiff_t>(all.size()) - 1);
  seek(all[static_cast<std::size_t>(to)].time);
  paused_ = true;
}

void Playback::set_speed(double speed) {
  if (std::isfinite(speed)) speed_ = std::clamp(speed, kSlowest, kFastestPlay);
}

void Playback::set_paused(bool paused) {
  if (!paused && time_ >= range_.last) time_ = range_.first;
  paused_ = paused;
}

void Playback::advance(double seconds) {
  if (paused_ || !(seconds > 0)) return;
  seek(time_ + speed_ * seconds);
  if (time_ >= range_.last) paused_ = true;
}

void Playback::obey(CommandKind kind, const std::string& name) {
  notice_.clear();
  switch (kind) {
    case CommandKind::pause:
      return set_paused(true);
    case CommandKind::resume:
      return set_paused(false);
    case CommandKind::step:
      return step(1);
    case CommandKind::reset:
      return seek(range_.first);
    case CommandKind::set_parameter:
      if (name != "stream.scalar") notice_ = "a recording cannot be changed: " + name + " stays as it is";
      break;
    case CommandKind::get_parameter:
      break;  // panels ask for a list now and then, of which a recording has none
    default:
      notice_ = "a recording takes no such command";
  }
  notice_from_ns_ = 0;
}

std::uint32_t Playback::run_number() const { return recording_.index().frames[recording_.frame_at(time_)].run; }

FeedView Playback::view(std::int64_t now_ns) {
  if (shown_time_ != time_) {
    shown_.scene = run().scene;
    show_particles(shown_);
    show_poses(shown_);
    show_hands(shown_);
    shown_time_ = time_;
  }
  // nothing of it grows old while it is shown
  shown_.frame_time_ns = now_ns;
  show_words(shown_, now_ns);
  shown_.lost_frames = recording_.index().lost_frames;
  shown_.refused = recording_.index().refused;
  return shown_;
}

void Playback::show_particles(FeedView& view) {
  const auto& frames = recording_.index().frames;
  const std::size_t i = recording_.frame_at(time_);
  view.frames = i + 1;
  view.frame = recording_.frame(i);
  show_earlier(view, i);
  const RecordedFrame &a = frames[i], &b = frames[std::min(i + 1, frames.size() - 1)];
  if (!view.frame || time_ <= a.time || b.run != a.run || b.time - a.time > kLongestGap) return;
  const auto next = recording_.frame(i + 1);
  if (next) view.frame = std::make_shared<const ParticleFrame>(between(*view.frame, *next, time_ - run().offset));
}

// Shows where particles were one recorded frame's time before, as their speeds follow from that without a step from
// frame to frame. i: the newest frame at time().
void Playback::show_earlier(FeedView& view, std::size_t i) {
  const auto& frames = recording_.index().frames;
  view.earlier = nullptr;
  const auto& scene = run().scene;
  if (i == 0 || !scene || std::ranges::none_of(scene->bodies, foams)) return;
  const RecordedFrame &a = frames[i - 1], &b = frames[i];
  if (b.run != a.run || b.time - a.time > kLongestGap) return;
  const auto first = recording_.frame(i - 1), second = recording_.frame(i);
  if (!first || !second) return;
  const double time = time_ - (b.time - a.time);
  view.earlier =
      time <= a.time ? first : std::make_shared<const ParticleFrame>(between(*first, *second, time - run().offset));
}

void Playback::show_poses(FeedView& view) {
  const auto& poses = recording_.index().poses;
  view.poses = nullptr;
  auto a = newest_at(poses, time_);
  // bodies may be told of a little after the particles
  if (a == poses.end() && !poses.empty()) a = poses.begin();
  if (a == poses.end() || a->run != run_number()) return;
  const auto first = recording_.sample<BodyPoses>(a->place);
  if (!first) return;
  const auto b = a + 1;
  const bool joined = time_ > a->time && b != poses.end() && b->run == a->run && b->time - a->time <= kLongestGap;
  const auto second = joined ? recording_.sample<BodyPoses>(b->place) : std::nullopt;
  view.poses = std::make_shared<const BodyPoses>(second ? between(*first, *second, time_ - run().offset) : *first);
}

void Playback::show_hands(FeedView& view) {
  for (std::uint32_t device = 0; device < kMaxDevices; ++device) {
    const auto& proxies = recording_.index().proxies[device];
    const auto newest = newest_at(proxies, time_);
    view.proxies[device].reset();
    if (newest == proxies.end() || newest->run != run_number() || time_ - newest->time > kOldProxy) continue;
    view.proxies[device] = recording_.sample<ProxySample>(newest->place);
    // whether the simulation stood still then; here the player does
    if (view.proxies[device]) view.proxies[device]->flags &= ~static_cast<std::uint32_t>(kPaused);
  }
}

// The states of processes, and what people must see.
void Playback::show_words(FeedView& view, std::int64_t now_ns) {
  const RecordingIndex& index = recording_.index();
  view.status.clear();
  const auto end = newest_at(index.statuses, time_);
  if (end != index.statuses.end()) {
    // from the newest back, so that the newest of each process counts
    for (auto it = end; time_ - it->time <= kOldStatus; --it) {
      if (const auto status = recording_.sample<Status>(it->place)) view.status.try_emplace(status->process, *status);
      if (it == index.statuses.begin()) break;
    }
  }
  // the player answers for the server: it is there, and says whether time passes
  Status& server = view.status[kServer];
  server.process = kServer;
  server.header.sequence = ++views_;
  if (server.state != "fault") server.state = paused_ ? "paused" : "running";
  std::erase_if(server.metrics, [](const Metric& metric) { return metric.name == "real_time_factor"; });
  if (!paused_) server.metrics.push_back({"real_time_factor", speed_});
  view.notice.clear();
  for (const TimedEvent& said : index.events)
    if (said.time <= time_ && time_ - said.time <= kForgetEvent && said.event.severity == Severity::fault)
      view.notice = said.event.process + ": " + said.event.text;
  if (notice_.empty()) return;
  if (notice_from_ns_ == 0) notice_from_ns_ = now_ns;
  if (now_ns - notice_from_ns_ > kNoticeNs) notice_.clear();
  view.notice = notice_;
}

std::optional<Eigen::Vector3d> Playback::handle_at(std::uint32_t device, double time) {
  if (device >= kMaxDevices) return std::nullopt;
  const auto& proxies = recording_.index().proxies[device];
  const auto newest = newest_at(proxies, std::clamp(time, range_.first, range_.last));
  if (newest == proxies.end()) return std::nullopt;
  const auto sample = recording_.sample<ProxySample>(newest->place);
  if (!sample) return std::nullopt;
  return to_vector(sample->proxy_pose.position);
}

std::optional<Eigen::Vector3d> Playback::handle_at_start(std::uint32_t device) {
  const auto scene = run().scene;
  if (!scene) return std::nullopt;
  for (const ProxyDescription& proxy : scene->proxies)
    if (proxy.device == device) return to_vector(proxy.pose.position);
  return std::nullopt;
}

}  // namespace palp
