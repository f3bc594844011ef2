// A video file written by ffmpeg, which runs as a child process and takes raw pictures from a pipe.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace palp {

class VideoPipe {
 public:
  // Pictures are RGB, rows from the bottom up. Throws std::runtime_error when the file cannot be written, ffmpeg cannot
  // be started or the size is none.
  VideoPipe(const std::string& file, int width, int height, double rate_hz);
  ~VideoPipe();  // close()
  VideoPipe(const VideoPipe&) = delete;
  VideoPipe& operator=(const VideoPipe&) = delete;

  // Blocks while ffmpeg is busy, at most 10 s. False (and said once) when it has died or hangs.
  bool write(const std::vector<std::uint8_t>& rgb);
  // Waits until ffmpeg has finished the file, at most 30 s. True if the video is whole.
  bool close();

  int width() const { return width_; }
  int height() const { return height_; }

 private:
  bool fail(const std::string& what);

  std::string file_;
  int width_ = 0;
  int height_ = 0;
  int pipe_ = -1;
  pid_t child_ = -1;
  bool ok_ = true;
};

}  // namespace palp
