#include "viewer/feed_state.h"

#include <utility>

namespace palp {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kForgetProxy = kSecond, kForgetStatus = 3 * kSecond, kForgetNotice = 6 * kSecond;

// When a frame was sent, on this host's clock. Its stamp counts only if it can be true: a recording that is replayed
// brings those of its own time, a hostile sender any.
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

void FeedState::add(const Received<SceneDescription>& received) {
  const SceneDescription& scene = received.message;
  if (from_server(scene.header) && scene.scene_hash == view_.scene->scene_hash &&
      scene.particle_count == view_.scene->particle_count) {
    return;  // sent again
  }
  view_.scene = std::make_shared<const SceneDescription>(scene);
  view_.frame = nullptr;
  view_.poses = nullptr;
  view_.proxies = {};
  view_.notice.clear();
  view_.lost_frames = 0;
  show_frame();
}

void FeedState::add(const Received<ParticleChunk>& received) {
  const std::uint64_t refused = assembler_.counts().refused;
  if (assembler_.add(received)) {
    auto frame = std::make_shared<ParticleFrame>();
    if (assembler_.take(*frame)) {
      newest_ = std::move(frame);
      show_frame();
    }
  }
  view_.refused += assembler_.counts().refused - refused;
}

void FeedState::show_frame() {
  if (!newest_ || !view_.scene || newest_->session != view_.scene->header.session) return;
  if (newest_->positions.size() != 3u * static_cast<std::size_t>(view_.scene->particle_count)) {
    ++view_.refused;
    return;
  }
  // numbers that run backwards begin anew
  if (view_.frame && newest_->frame > view_.frame->frame) view_.lost_frames += newest_->frame - view_.frame->frame - 1;
  view_.frame = newest_;
  view_.frame_time_ns = time_of(*newest_, same_host_);
  ++view_.frames;
}

void FeedState::add(const Received<BodyPoses>& received) {
  if (from_server(received.message.header)) view_.poses = std::make_shared<const BodyPoses>(received.message);
}

void FeedState::add(const Received<ProxySample>& received) {
  const ProxySample& sample = received.message;
  if (!from_server(sample.header) || sample.device >= kMaxDevices) return;
  view_.proxies[sample.device] = sample;
  proxy_at_ns_[sample.device] = received.t_receive_ns;
}

void FeedState::add(const Received<Status>& received) {
  view_.status[received.message.process] = received.message;
  status_at_ns_[received.message.process] = received.t_receive_ns;
}

void FeedState::add(const Received<Event>& received) {
  const Event& event = received.message;
  if (event.severity == Severity::fault) notice(event.process + ": " + event.text, received.t_receive_ns);
}

void FeedState::add(const Received<CommandReply>& received) {
  const CommandReply& reply = received.message;
  if (reply.command_session == own_session_) notice(reply.ok ? "" : reply.text, received.t_receive_ns);
}

void FeedState::forget(std::int64_t now_ns) {
  for (std::size_t i = 0; i < view_.proxies.size(); ++i) {
    if (view_.proxies[i] && now_ns - proxy_at_ns_[i] > kForgetProxy) view_.proxies[i].reset();
  }
  std::erase_if(status_at_ns_, [&](const auto& entry) {
    const bool old = now_ns - entry.second > kForgetStatus;
    if (old) view_.status.erase(entry.first);
    return old;
  });
  if (now_ns - notice_at_ns_ > kForgetNotice) view_.notice.clear();
}

}  // namespace palp
