#include "viewer/feed_state.h"

#include <utility>

namespace palp {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::size_t kMostServers = 8;
constexpr std::int64_t kForgetProxy = kSecond, kForgetStatus = 3 * kSecond, kForgetNotice = 6 * kSecond;

// Returns when a frame was sent, on this host's clock. Its stamp counts only if it can be true: a recording that is
// replayed brings those of its own time, a hostile sender any.
std::int64_t time_of(const ParticleFrame& frame, bool same_host) {
  const bool can_be =
      frame.t_send_ns > 0 && frame.t_send_ns <= frame.t_receive_ns && frame.t_receive_ns - frame.t_send_ns < kSecond;
  return same_host && can_be ? frame.t_send_ns : frame.t_receive_ns;
}

}  // namespace

bool FeedState::from_server(const Header& header) const {
  return view_.scene && view_.scene->header.session == header.session;
}

void FeedState::notice(const std::string& text, std::int64_t now_ns) {
  view_.notice = text;
  notice_at_ns_ = now_ns;
}

// Takes note that this server is there and returns whether it is the one that is shown.
bool FeedState::holds(const Header& header, std::int64_t now_ns) {
  const std::uint64_t before = servers_.held();
  const std::uint64_t held = servers_.look({&header.session, 1}, now_ns);
  if (held != before) go_over(before, now_ns);
  return held == header.session;
}

void FeedState::go_over(std::uint64_t before, std::int64_t now_ns) {
  assembler_ = {};
  newest_ = nullptr;
  if (const auto scene = scenes_.find(servers_.held()); scene != scenes_.end()) take_scene(scene->second);
  if (before != 0 && !view_.two_servers.empty())
    notice("the server that was shown has fallen silent; shown is " + roster_.name_of_session(servers_.held()), now_ns);
}

void FeedState::add(const Received<SceneDescription>& received) {
  const std::uint64_t session = received.message.header.session;
  if (scenes_.size() >= kMostServers && !scenes_.contains(session)) {
    const std::uint64_t held = servers_.held();
    std::erase_if(scenes_, [&](const auto& entry) { return entry.first != held; });
  }
  auto scene = std::make_shared<const SceneDescription>(received.message);
  scenes_[session] = scene;
  if (holds(received.message.header, received.t_receive_ns)) take_scene(std::move(scene));
}

void FeedState::take_scene(std::shared_ptr<const SceneDescription> scene) {
  if (from_server(scene->header) && scene->scene_hash == view_.scene->scene_hash &&
      scene->particle_count == view_.scene->particle_count) {
    return;  // sent again
  }
  view_.scene = std::move(scene);
  view_.frame = nullptr;
  view_.earlier = nullptr;
  view_.poses = nullptr;
  view_.proxies = {};
  view_.notice.clear();
  view_.told.clear();
  view_.refusal.clear();
  view_.lost_frames = 0;
  show_frame();
}

void FeedState::add(const Received<ParticleChunk>& received) {
  if (!holds(received.message.header, received.t_receive_ns)) return;
  const std::uint64_t refused = assembler_.counts().refused;
  if (assembler_.add(received)) {
    std::shared_ptr<ParticleFrame> frame = pool_.take();
    if (assembler_.take(*frame)) {
      newest_ = std::move(frame);
      show_frame();
    }
  }
  view_.refused += assembler_.counts().refused - refused;
}

void FeedState::add(std::shared_ptr<const ParticleFrame> frame) {
  Header header;
  header.session = frame->session;
  if (!holds(header, frame->t_receive_ns)) return;
  newest_ = std::move(frame);
  if (!show_frame()) return;
  ++view_.shared_frames;
  view_.frame_time_ns = time_of(*newest_, true);
}

// Returns whether there is one to show.
bool FeedState::show_frame() {
  if (!newest_ || !view_.scene || newest_->session != view_.scene->header.session) return false;
  if (newest_->positions.size() != 3u * static_cast<std::size_t>(view_.scene->particle_count)) {
    ++view_.refused;
    return false;
  }
  // numbers that run backwards begin anew
  if (view_.frame && newest_->frame > view_.frame->frame) view_.lost_frames += newest_->frame - view_.frame->frame - 1;
  // of the same time are frames of a simulation that stands
  const double before = view_.frame ? view_.frame->sim_time : newest_->sim_time;
  if (newest_->sim_time != before) view_.earlier = newest_->sim_time > before ? view_.frame : nullptr;
  view_.frame = newest_;
  view_.frame_time_ns = time_of(*newest_, same_host_);
  ++view_.frames;
  return true;
}

void FeedState::add(const Received<BodyPoses>& received) {
  const Header& header = received.message.header;
  if (holds(header, received.t_receive_ns) && from_server(header))
    view_.poses = std::make_shared<const BodyPoses>(received.message);
}

void FeedState::add(const Received<ProxySample>& received) {
  const ProxySample& sample = received.message;
  if (!holds(sample.header, received.t_receive_ns) || !from_server(sample.header) || sample.device >= kMaxDevices)
    return;
  view_.proxies[sample.device] = sample;
  proxy_at_ns_[sample.device] = received.t_receive_ns;
}

void FeedState::add(const Received<Status>& received) {
  const Status& status = received.message;
  roster_.add(received);
  if (status.process == kServerName) {
    const bool ended = has_ended(status);
    if (ended ? servers_.held() != status.header.session : !holds(status.header, received.t_receive_ns)) return;
    if (ended) servers_.let_go(status.header.session);
  }
  view_.status[status.process] = status;
  status_at_ns_[status.process] = received.t_receive_ns;
}

void FeedState::add(const Received<Event>& received) {
  const Event& event = received.message;
  if (event.process == kServerName && servers_.held() != 0 && event.header.session != servers_.held()) return;
  if (event.severity == Severity::fault) notice(event.process + ": " + event.text, received.t_receive_ns);
}

void FeedState::add(const Received<CommandReply>& received) {
  const CommandReply& reply = received.message;
  if (servers_.held() != 0 && reply.header.session != servers_.held()) return;
  if (reply.command_session != own_session_) return;
  for (const auto& [name, sequence] : asked_) {
    if (sequence != reply.command_sequence) continue;
    if (reply.ok) view_.told[name] = std::make_shared<const std::string>(reply.text);
    return;
  }
  ++view_.answers;
  view_.refusal = reply.ok ? "" : reply.text;
  notice(view_.refusal, received.t_receive_ns);
}

void FeedState::forget(std::int64_t now_ns) {
  for (std::size_t i = 0; i < view_.proxies.size(); ++i) {
    if (view_.proxies[i] && now_ns - proxy_at_ns_[i] > kForgetProxy) view_.proxies[i].reset();
  }
  std::erase_if(status_at_ns_, [&](const auto& entry) {
    // the last word of a server that ended stays until another one speaks
    const bool last_word = entry.first == kServerName && has_ended(view_.status[entry.first]);
    const bool old = now_ns - entry.second > kForgetStatus && !last_word;
    if (old) view_.status.erase(entry.first);
    return old;
  });
  if (now_ns - notice_at_ns_ > kForgetNotice) view_.notice.clear();
  servers_.look({}, now_ns);
  roster_.forget(now_ns);
  const std::uint64_t other = servers_.rival(kSecond / 2);
  view_.two_servers = other == 0 || servers_.held() == 0
                          ? ""
                          : "two servers run in this domain: shown is " + roster_.name_of_session(servers_.held()) +
                                ", passed over is " + roster_.name_of_session(other) + "; end one of the two";
}

}  // namespace palp
