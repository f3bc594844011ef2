// The mean of several pictures of one scene: what is smoothed is light, not the numbers that stand for it.
#pragma once

#include <cstdint>
#include <vector>

#include <osg/Vec2d>

#include "viewer/stage.h"

namespace palp {

// One thread uses it.
class PictureMean {
 public:
  // Takes one more picture in, of the size of those before.
  void add(const Picture& picture);
  // Returns the mean of those taken in, of which there is one at least. Of equal pictures it is that picture.
  Picture mean() const;

 private:
  int width_ = 0, height_ = 0;      // [pixels]
  std::vector<std::uint32_t> sum_;  // of light, 0 .. 65535 a picture
  std::uint32_t count_ = 0;
};

// Returns how far the k-th of count pictures is displaced, right and up, within a pixel: -0.5 .. 0.5 [pixels]. The
// first ones fill the pixel as evenly as all (Halton 1960, bases 2 and 3); together they are displaced by nothing.
osg::Vec2d displacement(int k, int count);

}  // namespace palp
