// Pictures and videos, written by a thread of their own so that drawing does not wait for compression.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "viewer/stage.h"

namespace palp {

// Returns the name of the picture of that number in a series: DIR/NAME-0007.png for DIR/NAME.png.
std::string numbered(const std::string& file, int number);

// Returns the name of a picture that is taken by hand: that of the time.
std::string screenshot_name();

// Calls from one thread. Failures are logged, counted and never thrown after construction.
class Capture {
 public:
  Capture();
  ~Capture();  // finish()

  // Queues a picture. The file appears whole: it is written beside and then renamed. PNGs are never dropped.
  void write_png(const std::string& file, Picture picture);

  // Starts ffmpeg (from PATH, H.264) for pictures of this size. Throws std::runtime_error when it cannot be started or
  // the file cannot be written.
  void open_video(const std::string& file, int width, int height, double rate_hz);
  bool video_open() const;
  // Queues a picture that is shown at this time [s] after the first. It is repeated to hold the pace of the clock, so a
  // video of a slow viewer is not fast. False, and counted, when the encoder is behind (the next picture fills the gap)
  // or the size is another.
  bool write_video(const Picture& picture, double time);
  // Waits until no more than a few pictures are queued, so that whoever makes them as fast as it can, one after the
  // other, has none dropped and does not fill the memory.
  void wait_for_room();

  // Waits until everything queued is on disk and the video is closed. True if nothing failed. May be called twice.
  bool finish();
  std::uint64_t dropped_video_pictures() const;

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace palp
