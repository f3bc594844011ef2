#include "viewer/capture.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <ctime>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <osg/Image>
#include <osgDB/Options>
#include <osgDB/WriteFile>

#include "viewer/video_pipe.h"

namespace palp {
namespace {

constexpr std::size_t kMaxQueuedVideo = 8;  // pictures
constexpr std::uint64_t kMaxRepeat = 300;   // a viewer that was stopped for long does not fill the disk

bool save_png(const std::string& file, Picture& picture) {
  osg::ref_ptr<osg::Image> image = new osg::Image;
  image->setImage(picture.width, picture.height, 1, GL_RGB, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data(),
                  osg::Image::NO_DELETE, 1);
  osg::ref_ptr<osgDB::Options> options = new osgDB::Options("PNG_COMPRESSION 5");
  const std::string unfinished = file + ".part.png";
  if (osgDB::writeImageFile(*image, unfinished, options) && std::rename(unfinished.c_str(), file.c_str()) == 0) {
    spdlog::info("wrote {}", file);
    return true;
  }
  std::remove(unfinished.c_str());
  spdlog::error("cannot write {}: check that its folder exists, can be written and has room", file);
  return false;
}

}  // namespace

class Capture::Worker {
 public:
  Worker() : thread_([this] { run(); }) {}
  ~Worker() { finish(); }

  void write_png(const std::string& file, Picture picture) { push({file, std::move(picture), 1}); }

  void open_video(const std::string& file, int width, int height, double rate_hz) {
    video_ = std::make_unique<VideoPipe>(file, width, height, rate_hz);
    rate_hz_ = rate_hz;
    written_ = 0;
  }

  bool write_video(const Picture& picture, double time) {
    if (!video_) return false;
    if (picture.width != video_->width() || picture.height != video_->height()) return drop();
    // as many pictures as there should be by now
    const auto due = static_cast<std::uint64_t>(std::max(0.0, std::floor(time * rate_hz_ + 0.5))) + 1;
    if (due <= written_) return true;
    {
      const std::lock_guard lock(mutex_);
      if (queued_video_ >= kMaxQueuedVideo) return drop();
      ++queued_video_;
    }
    push({{}, picture, std::min(due - written_, kMaxRepeat)});
    written_ = due;
    return true;
  }

  void wait_for_room() {
    std::unique_lock lock(mutex_);
    taken_.wait(lock, [this] { return jobs_.size() < kMaxQueuedVideo && queued_video_ < kMaxQueuedVideo; });
  }

  bool finish() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_one();
    if (thread_.joinable()) thread_.join();
    if (video_ && !video_->close()) failed_ = true;
    video_.reset();
    return !failed_;
  }

  bool video_open() const { return video_ != nullptr; }
  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Job {
    std::string png;  // empty: for the video
    Picture picture;
    std::uint64_t repeat = 1;
  };

  bool drop() {
    ++dropped_;
    return false;
  }

  void push(Job job) {
    {
      const std::lock_guard lock(mutex_);
      if (stop_) return;
      jobs_.push_back(std::move(job));
    }
    wake_.notify_one();
  }

  void run() {
    for (;;) {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stop_ || !jobs_.empty(); });
      if (jobs_.empty()) return;
      Job job = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      taken_.notify_one();
      if (!job.png.empty()) {
        if (!save_png(job.png, job.picture)) failed_ = true;
        continue;
      }
      for (std::uint64_t i = 0; i < job.repeat; ++i) {
        if (!video_->write(job.picture.rgb)) failed_ = true;
      }
      lock.lock();
      --queued_video_;
      taken_.notify_one();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_, taken_;
  std::deque<Job> jobs_;          // under mutex_
  std::size_t queued_video_ = 0;  // under mutex_
  bool stop_ = false;             // under mutex_
  std::atomic<bool> failed_ = false;
  std::uint64_t dropped_ = 0;
  std::uint64_t written_ = 0;
  double rate_hz_ = 30;
  std::unique_ptr<VideoPipe> video_;
  std::thread thread_;  // last: starts when the rest is there
};

std::string numbered(const std::string& file, int number) {
  const std::filesystem::path path(file);
  return (path.parent_path() / fmt::format("{}-{:04d}{}", path.stem().string(), number, path.extension().string()))
      .string();
}

std::string screenshot_name() { return fmt::format("palp-{:%Y%m%d-%H%M%S}.png", fmt::localtime(std::time(nullptr))); }

Capture::Capture() : worker_(std::make_unique<Worker>()) {}
Capture::~Capture() = default;

void Capture::write_png(const std::string& file, Picture picture) { worker_->write_png(file, std::move(picture)); }
void Capture::open_video(const std::string& file, int width, int height, double rate_hz) {
  worker_->open_video(file, width, height, rate_hz);
}
bool Capture::video_open() const { return worker_->video_open(); }
bool Capture::write_video(const Picture& picture, double time) { return worker_->write_video(picture, time); }
void Capture::wait_for_room() { worker_->wait_for_room(); }
bool Capture::finish() { return worker_->finish(); }
std::uint64_t Capture::dropped_video_pictures() const { return worker_->dropped(); }

}  // namespace palp
