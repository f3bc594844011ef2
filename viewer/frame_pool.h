// Frames whose memory goes round: a million particles are 16 MB, which would cost as much to get from the system 60
// times a second as to fill.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "idl/particle_frame.h"

namespace palp {

class FramePool {
 public:
  // Returns a frame to fill, with values of an earlier one; it comes back when nobody, of any thread, holds it any
  // more.
  std::shared_ptr<ParticleFrame> take() {
    std::unique_ptr<ParticleFrame> frame;
    {
      const std::lock_guard lock(spare_->mutex);
      if (!spare_->frames.empty()) {
        frame = std::move(spare_->frames.back());
        spare_->frames.pop_back();
      }
    }
    if (!frame) frame = std::make_unique<ParticleFrame>();
    return {frame.release(), [spare = spare_](ParticleFrame* used) {
              std::unique_ptr<ParticleFrame> back(used);
              const std::lock_guard lock(spare->mutex);
              if (spare->frames.size() < kMostSpare) spare->frames.push_back(std::move(back));
            }};
  }

 private:
  static constexpr std::size_t kMostSpare = 3;
  struct Spare {
    std::mutex mutex;
    std::vector<std::unique_ptr<ParticleFrame>> frames;
  };
  std::shared_ptr<Spare> spare_ = std::make_shared<Spare>();
};

}  // namespace palp
