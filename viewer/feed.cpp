#include "viewer/feed.h"

#include <atomic>
#include <chrono>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "idl/clock.h"
#include "idl/frame_ring.h"
#include "idl/topics.h"
#include "idl/validate.h"

namespace palp {
namespace {

// Long enough to sleep between frames, short enough for a key to act at once.
constexpr std::chrono::milliseconds kRound{10};
// From one look at shared memory to the next: an eighth of the time between frames.
constexpr std::chrono::milliseconds kRingLook{2};

// A reader with the memory that its samples go through.
template <class T>
class Inlet {
 public:
  explicit Inlet(Bus& bus) : reader_(bus.reader<T>()) {}

  bool pour_into(FeedState& state) {
    samples_.clear();
    if (reader_->take_all(samples_) == 0) return false;
    for (const Received<T>& sample : samples_) state.add(sample);
    return true;
  }

  // Samples refused so far. The first of each kind are told of.
  std::uint64_t refused() {
    const DropCounts drops = reader_->drops();
    if (drops.wrong_version > 0 && !std::exchange(warned_version_, true)) {
      spdlog::warn("{}", wrong_version_sentence(topic_of<T>().name, drops));
    }
    const std::uint64_t unsound = drops.not_finite + drops.malformed;
    if (unsound > 0 && !std::exchange(warned_unsound_, true)) {
      spdlog::warn("a sample on topic {} was malformed or not finite and is passed over; more are only counted",
                   topic_of<T>().name);
    }
    return drops.wrong_version + unsound;
  }

  bool wait() { return reader_->wait(kRound); }

 private:
  std::unique_ptr<Reader<T>> reader_;
  std::vector<Received<T>> samples_;
  bool warned_version_ = false;
  bool warned_unsound_ = false;
};

}  // namespace

class Feed::Impl {
 public:
  explicit Impl(const BusOptions& options)
      : bus_(open_bus(options)),
        state_(!options.network && options.peers.empty(), bus_->session()),
        inlets_(Inlet<SceneDescription>(*bus_), Inlet<BodyPoses>(*bus_), Inlet<ProxySample>(*bus_),
                Inlet<Status>(*bus_), Inlet<Event>(*bus_), Inlet<CommandReply>(*bus_)),
        commands_(bus_->writer<Command>()),
        status_(bus_->writer<Status>()),
        thread_([this] { run(); }) {}

  ~Impl() {
    stop_ = true;
    thread_.join();
  }

  FeedView view() const {
    const std::lock_guard lock(mutex_);
    return view_;
  }

  void send(Command command) {
    const std::lock_guard lock(mutex_);
    to_send_.push_back(std::move(command));
  }

  void report(Status status) {
    const std::lock_guard lock(mutex_);
    to_report_ = std::move(status);
  }

 private:
  void run() {
    while (!stop_) {
      wait();
      // descriptions first: frames are of no use without
      std::apply([this](auto&... inlet) { (inlet.pour_into(state_), ...); }, inlets_);
      choose_way();
      if (chunks_) chunks_->pour_into(state_);
      state_.forget(now_ns());
      const std::string& two_servers = state_.view().two_servers;
      if (!two_servers.empty() && !std::exchange(warned_two_servers_, true)) spdlog::warn("{}", two_servers);
      std::uint64_t refused = refused_before_ + (chunks_ ? chunks_->refused() : 0);
      std::apply([&refused](auto&... inlet) { ((refused += inlet.refused()), ...); }, inlets_);
      exchange(refused);
    }
  }

  // Waits until particles may be there or a round is over.
  void wait() {
    if (chunks_) {
      chunks_->wait();
    } else if (!ring_) {
      std::get<Inlet<SceneDescription>>(inlets_).wait();
    } else {
      const std::int64_t end_ns = now_ns() + std::chrono::nanoseconds(kRound).count();
      while (!take_shared() && now_ns() < end_ns) std::this_thread::sleep_for(kRingLook);
    }
  }

  // Opens what the particles of the server that is shown come by: the ring that it has in shared memory, where this
  // process finds it, else the bus. While nobody reads chunks there, the server sends none.
  void choose_way() {
    const std::shared_ptr<const SceneDescription>& scene = state_.view().scene;
    if (!scene || scene == way_of_) return;
    way_of_ = scene;
    try {
      ring_.emplace(RingPlace{bus_->domain(), scene->header.session, scene->particle_count});
      if (chunks_) refused_before_ += chunks_->refused();
      chunks_.reset();
      state_.come_by("shared memory");
      spdlog::info("particles come by shared memory");
    } catch (const std::exception& error) {
      take_the_bus(error.what());
    }
  }

  void take_the_bus(const std::string& why) {
    ring_.reset();
    if (!chunks_) chunks_.emplace(*bus_);
    state_.come_by("bus");
    spdlog::info("particles come over the bus: {}", why);
  }

  // Returns whether there was something.
  bool take_shared() {
    std::shared_ptr<ParticleFrame> frame = state_.spare_frame();
    const RingAnswer answer = ring_->take(*frame);
    if (answer == RingAnswer::frame) state_.add(std::move(frame));
    if (answer == RingAnswer::refused) state_.count_refused();
    if (answer == RingAnswer::closed) take_the_bus("the server has closed its shared memory");
    return answer != RingAnswer::nothing;
  }

  // Meets the thread that draws: out with the view, in with what is to be sent. Sends outside of the lock.
  void exchange(std::uint64_t refused) {
    std::deque<Command> commands;
    std::optional<Status> status;
    {
      FeedView view = state_.view();
      view.refused += refused;
      const std::lock_guard lock(mutex_);
      std::swap(view_, view);
      commands.swap(to_send_);
      status.swap(to_report_);
    }
    for (Command& command : commands) {
      if (!commands_->publish(command)) spdlog::warn("the command could not be sent");
      if (command.kind == CommandKind::get_parameter) state_.expect(command.name, command.header.sequence);
    }
    if (status) status_->publish(*status);
  }

  std::unique_ptr<Bus> bus_;
  FeedState state_;  // of the thread
  bool warned_two_servers_ = false;
  std::tuple<Inlet<SceneDescription>, Inlet<BodyPoses>, Inlet<ProxySample>, Inlet<Status>, Inlet<Event>,
             Inlet<CommandReply>>
      inlets_;
  std::shared_ptr<const SceneDescription> way_of_;  // whose particles come by the next two, of which one is there
  std::optional<FrameRingReader> ring_;
  std::optional<Inlet<ParticleChunk>> chunks_;
  std::uint64_t refused_before_ = 0;  // chunks, by readers that are no more
  std::unique_ptr<Writer<Command>> commands_;
  std::unique_ptr<Writer<Status>> status_;

  mutable std::mutex mutex_;
  FeedView view_;                    // under mutex_
  std::deque<Command> to_send_;      // under mutex_
  std::optional<Status> to_report_;  // under mutex_
  std::atomic<bool> stop_ = false;
  std::thread thread_;  // last: starts when the rest is there
};

Feed::Feed(const BusOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Feed::~Feed() = default;

FeedView Feed::view() const { return impl_->view(); }

void Feed::send(CommandKind kind, const std::string& name, const std::string& value) {
  Command command;
  command.kind = kind;
  command.name = name;
  command.value = value;
  impl_->send(std::move(command));
}

void Feed::report(const std::string& state, std::vector<Metric> metrics) {
  Status status;
  status.process = "viewer";
  status.state = state;
  status.metrics = std::move(metrics);
  impl_->report(std::move(status));
}

}  // namespace palp
