// Plays a recording in place of a bus: what is shown at a time, and the controls of a player. Menus, keys and the
// timeline all call these functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "viewer/feed_state.h"
#include "viewer/recording.h"

namespace palp {

// [s] of playing, which is simulated time (recording_index.h).
struct TimeRange {
  double first = 0, last = 0;
};

inline constexpr double kSlowest = 0.1, kFastestPlay = 10;

// One thread.
class Playback {
 public:
  // Throws McapError with one sentence when nothing can be shown of the file. Logs what of it is damaged.
  explicit Playback(const std::string& file);

  TimeRange range() const { return range_; }  // from the first frame of particles to the last
  double time() const { return time_; }       // that is shown [s]
  double speed() const { return speed_; }     // simulated seconds in one of the clock
  bool paused() const { return paused_; }

  // Goes to a time, cut to the range.
  void seek(double time);
  // Goes so many recorded frames on, or back, and pauses there.
  void step(int frames);
  // Cut to kSlowest .. kFastestPlay; what is not finite changes nothing.
  void set_speed(double speed);
  // Going on at the end begins again.
  void set_paused(bool paused);
  // Lets so much time of the clock pass [s]. Pauses at the end.
  void advance(double seconds);
  // Does what a server would: pause, resume, step, reset (which goes to the beginning). What cannot be done with a
  // recording is told in the view's notice.
  void obey(CommandKind kind, const std::string& name);

  // Returns what is shown at time(), as if it had just come from a bus. Between two recorded frames of a run that are
  // at most kLongestGap apart, particles and bodies are between theirs. now_ns: CLOCK_MONOTONIC, or that of a film.
  FeedView view(std::int64_t now_ns);
  // Returns where the handle of a device's tool is at a time of playing [s]; nothing where the recording does not say.
  std::optional<Eigen::Vector3d> handle_at(std::uint32_t device, double time);
  // Returns where the scene that is shown has it at the start.
  std::optional<Eigen::Vector3d> handle_at_start(std::uint32_t device);

  static constexpr double kLongestGap = 0.1;  // [s]

 private:
  std::uint32_t run_number() const;
  const RecordedRun& run() const { return recording_.index().runs[run_number()]; }
  void show_particles(FeedView& view);
  void show_earlier(FeedView& view, std::size_t i);
  void show_poses(FeedView& view);
  void show_hands(FeedView& view);
  void show_words(FeedView& view, std::int64_t now_ns);

  Recording recording_;
  TimeRange range_;
  double time_ = 0, speed_ = 1;
  bool paused_ = false;
  std::string notice_;
  std::int64_t notice_from_ns_ = 0;  // 0: it was not shown yet
  FeedView shown_;                   // of shown_time_
  double shown_time_ = -1;
  std::uint64_t views_ = 0;  // handed out
};

}  // namespace palp
