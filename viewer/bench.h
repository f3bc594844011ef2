// How long pictures take: a benchmark of the drawing alone, with a made-up fluid in place of a server.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "viewer/stage.h"

namespace palp {

// All times are medians [ms].
struct DrawingTimes {
  std::size_t particles = 0;
  std::size_t seen = 0;      // of them, those that others do not hide
  std::size_t pictures = 0;  // that the times of whole pictures are of
  double take = 0;           // to take over a frame of particles, without drawing
  double picture = 0;        // to draw one, until OpenGL has done all of it; without take
  double slowest = 0;        // 99 % of pictures took at most this
  // The passes, by name, all of a name together; "picture" is the rest. Each is waited for, so that their sum is more
  // than a picture.
  std::map<std::string, double> passes;
};

// Draws a pool of so many particles whose waves move, for about `seconds` [s] and at least ten pictures of each kind.
// The stage is left with the first frame of that scene. Thread: the one that renders.
DrawingTimes time_drawing(Stage& stage, std::size_t particles, Medium medium, double seconds);

// A table for people.
std::string table_of(const DrawingTimes& times);

}  // namespace palp
