#include "viewer/recording_index.h"

#include <algorithm>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "idl/cdr.h"
#include "idl/particle_frame.h"
#include "idl/session_hold.h"

namespace palp {
namespace {

constexpr std::uint64_t kProxyEveryNs = 2'000'000;  // of what a hand feels no more is kept
constexpr double kReset = 0.1;                      // [s] that simulated time runs back by when it begins anew
constexpr double kLate = 0.5;                       // [s] ahead of a run that has just begun: of the run before
constexpr std::size_t kOpenFrames = 3;
constexpr std::size_t kMostEvents = 10'000;

// A sample as the index keeps it until all are in order.
struct Entry {
  std::uint64_t log_time_ns = 0;
  TopicNumber topic{};
  SamplePlace place;
  std::uint64_t session = 0;
  double sim_time = 0;                 // [s]
  std::uint32_t device = 0;            // of a proxy
  std::uint64_t frame = 0;             // of a chunk of particles, and so on
  std::uint32_t chunk = 0, count = 0;  // which chunk of how many
  std::uint32_t particle_count = 0;
  std::size_t event = 0;  // in Samples::events
};

struct Scene {
  std::uint64_t session = 0;
  std::shared_ptr<const SceneDescription> description;
};

// All samples of a file that can be read.
class Samples {
 public:
  std::vector<Entry> entries;  // by time once read() has returned
  std::vector<Scene> scenes;
  std::vector<Event> events;

  void read(const McapReader& reader, RecordingIndex& index) {
    std::map<std::uint16_t, const TopicRow*> topics;
    std::uint32_t message = 0;
    McapVisitor visitor;
    visitor.channel = [&](const McapChannel& channel) {
      for (const TopicRow& row : kTopics)
        if (channel.encoding == "cdr" && channel.topic == row.name) topics[channel.id] = &row;
    };
    visitor.chunk = [&](std::uint64_t offset) {
      index.chunks.push_back(offset);
      message = 0;
    };
    visitor.message = [&](const McapMessage& m, Compression) {
      const auto chunk = static_cast<std::uint32_t>(index.chunks.size() - 1);
      const SamplePlace place{chunk, message++};
      const auto topic = topics.find(m.channel_id);
      // palp puts every message into a chunk; what stands outside of any has no place to be found at
      if (topic == topics.end() || index.chunks.empty()) return;
      add(static_cast<TopicNumber>(topic->second - kTopics.data()), m, place);
    };
    const McapScan scan = reader.scan(visitor);
    index.remarks = scan.damages;
    if (!scan.complete && scan.damages.empty()) index.remarks.push_back(reader.path() + ": ends too early");
    index.refused = drops_.wrong_version + drops_.not_finite + drops_.malformed;
    if (topics.empty())
      throw McapError(reader.path() + ": holds no topic of palp, expected a recording of palp-record or palp-run");
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.log_time_ns < b.log_time_ns; });
  }
  const DropCounts& drops() const { return drops_; }

 private:
  // Returns whether the sample is sound.
  template <class T>
  bool decode(const McapMessage& m, T& out) {
    const Fault fault = from_cdr(m.data, out);
    count(fault, out.header, drops_);
    return fault == Fault::none;
  }

  void add(TopicNumber topic, const McapMessage& m, SamplePlace place) {
    Entry entry;
    entry.log_time_ns = m.log_time_ns;
    entry.topic = topic;
    entry.place = place;
    if (take(m, entry)) entries.push_back(entry);
  }

  // Reads what the index needs of a sample. False: it is refused, or not needed.
  bool take(const McapMessage& m, Entry& entry) {
    switch (entry.topic) {
      case TopicNumber::of_SceneDescription:
        return take_scene(m);
      case TopicNumber::of_ParticleChunk:
        if (!decode(m, chunk_)) return false;
        entry.session = chunk_.header.session;
        entry.sim_time = chunk_.sim_time;
        entry.frame = chunk_.frame;
        entry.chunk = chunk_.chunk;
        entry.count = chunk_.chunk_count;
        entry.particle_count = chunk_.particle_count;
        return true;
      case TopicNumber::of_BodyPoses:
        if (!decode(m, poses_)) return false;
        entry.session = poses_.header.session;
        entry.sim_time = poses_.sim_time;
        return true;
      case TopicNumber::of_ProxySample:
        return take_proxy(m, entry);
      case TopicNumber::of_Status:
        return decode(m, status_);
      case TopicNumber::of_Event:
        entry.event = events.size();
        if (!decode(m, event_) || events.size() >= kMostEvents) return false;
        events.push_back(event_);
        return true;
      default:
        return false;
    }
  }

  bool take_scene(const McapMessage& m) {
    auto scene = std::make_shared<SceneDescription>();
    if (decode(m, *scene)) scenes.push_back({scene->header.session, scene});
    return false;
  }

  bool take_proxy(const McapMessage& m, Entry& entry) {
    if (!decode(m, proxy_)) return false;
    const auto key = std::pair(proxy_.header.session, proxy_.device);
    const auto [last, first] = proxy_at_ns_.try_emplace(key, m.log_time_ns);
    if (!first && m.log_time_ns >= last->second && m.log_time_ns - last->second < kProxyEveryNs) return false;
    last->second = m.log_time_ns;
    entry.session = proxy_.header.session;
    entry.sim_time = proxy_.sim_time;
    entry.device = proxy_.device;
    return true;
  }

  DropCounts drops_;
  std::map<std::pair<std::uint64_t, std::uint32_t>, std::uint64_t> proxy_at_ns_;
  ParticleChunk chunk_;
  BodyPoses poses_;
  ProxySample proxy_;
  Status status_;
  Event event_;
};

// Lays samples out along the time of playing.
class Layout {
 public:
  Layout(const Samples& samples, RecordingIndex& index) : samples_(samples), index_(index) {}

  void lay_out() {
    for (const Entry& entry : samples_.entries) {
      if (entry.topic == TopicNumber::of_Status) {
        index_.statuses.push_back({now_, entry.place, 0});
      } else if (entry.topic == TopicNumber::of_Event) {
        index_.events.push_back({now_, samples_.events[entry.event]});
      } else if (const std::optional<double> time = time_of(entry)) {
        add(entry, *time);
      }
    }
    index_.lost_frames += open_.size();
    const auto earlier = [](const auto& a, const auto& b) { return a.time < b.time; };
    std::stable_sort(index_.frames.begin(), index_.frames.end(), earlier);
    std::stable_sort(index_.poses.begin(), index_.poses.end(), earlier);
    for (auto& proxies : index_.proxies) std::stable_sort(proxies.begin(), proxies.end(), earlier);
  }

 private:
  struct Open {
    std::uint64_t frame = 0;
    double time = 0;
    std::vector<std::optional<SamplePlace>> places;
    std::size_t missing = 0;
  };

  std::shared_ptr<const SceneDescription> scene_of(std::uint64_t session) const {
    std::shared_ptr<const SceneDescription> newest;
    for (const Scene& scene : samples_.scenes)
      if (scene.session == session) newest = scene.description;
    return newest;
  }

  // Returns when a server's sample is played; nothing: another server is shown, or it came too late to be of a run.
  std::optional<double> time_of(const Entry& entry) {
    const auto log_time = static_cast<std::int64_t>(entry.log_time_ns);
    if (servers_.look({&entry.session, 1}, log_time) != entry.session) return std::nullopt;
    std::vector<RecordedRun>& runs = index_.runs;
    const bool begins =
        runs.empty() || runs.back().session != entry.session || entry.sim_time + runs.back().offset < now_ - kReset;
    if (begins) {
      const double offset = runs.empty() ? 0 : now_ - entry.sim_time;
      const double first = entry.sim_time + offset;
      runs.push_back({entry.session, first, first, offset, scene_of(entry.session)});
      index_.lost_frames += open_.size();
      open_.clear();
      now_ = first;
    }
    RecordedRun& run = runs.back();
    const double time = std::max(entry.sim_time + run.offset, run.first);
    const bool of_the_run_before = runs.size() > 1 && run.last - run.first < kLate && time - run.last > kLate;
    if (of_the_run_before) return std::nullopt;
    now_ = run.last = std::max(run.last, time);
    return time;
  }

  void add(const Entry& entry, double time) {
    const auto run = static_cast<std::uint32_t>(index_.runs.size() - 1);
    if (entry.topic == TopicNumber::of_BodyPoses) index_.poses.push_back({time, entry.place, run});
    if (entry.topic == TopicNumber::of_ProxySample) index_.proxies[entry.device].push_back({time, entry.place, run});
    if (entry.topic == TopicNumber::of_ParticleChunk) add_chunk(entry, time);
  }

  void add_chunk(const Entry& entry, double time) {
    const auto& scene = index_.runs.back().scene;
    if (!scene) {
      ++without_scene_;
      return;
    }
    if (entry.particle_count != scene->particle_count) {
      ++index_.refused;
      return;
    }
    auto open = std::find_if(open_.begin(), open_.end(), [&](const Open& o) { return o.frame == entry.frame; });
    if (open == open_.end()) {
      if (open_.size() == kOpenFrames) {
        open_.erase(open_.begin());
        ++index_.lost_frames;
      }
      open = open_.insert(open_.end(), {entry.frame, time, {}, entry.count});
      open->places.resize(entry.count);
    }
    if (open->places[entry.chunk]) return;
    open->places[entry.chunk] = entry.place;
    if (--open->missing > 0) return;
    index_.frames.push_back({open->time, static_cast<std::uint32_t>(index_.runs.size() - 1),
                             static_cast<std::uint32_t>(index_.frame_places.size()), entry.count});
    for (const auto& place : open->places) index_.frame_places.push_back(*place);
    open_.erase(open);
  }

 public:
  std::uint64_t without_scene() const { return without_scene_; }

 private:
  const Samples& samples_;
  RecordingIndex& index_;
  SessionHold servers_{kViewHold};
  double now_ = 0;  // [s] of playing, up to where it is laid out
  std::vector<Open> open_;
  std::uint64_t without_scene_ = 0;  // chunks
};

}  // namespace

RecordingIndex index_recording(const McapReader& reader) {
  RecordingIndex index;
  Samples samples;
  samples.read(reader, index);
  Layout layout(samples, index);
  layout.lay_out();
  const DropCounts& drops = samples.drops();
  const std::string version = fmt::format(
      "{}: was recorded with protocol version {} and this viewer reads version {}: play it with the release "
      "of palp that recorded it",
      reader.path(), drops.other_version, kProtocolVersion);
  if (!index.frames.empty()) {
    if (drops.wrong_version > 0) index.remarks.push_back(version);
    return index;
  }
  if (drops.wrong_version > 0) throw McapError(version);
  if (layout.without_scene() > 0)
    throw McapError(reader.path() + ": holds particles but not their scene: record palp/scene, too");
  const std::string damage = index.remarks.empty() ? "" : "; " + index.remarks.front();
  throw McapError(reader.path() + ": holds no whole frame of particles: record palp/particles and palp/scene" + damage);
}

}  // namespace palp
