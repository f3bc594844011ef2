// The thing that was clicked in the picture: found once, then told anew as it moves. Used by the thread that renders.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "viewer/panel_data.h"
#include "viewer/session.h"
#include "viewer/stage.h"

namespace palp {

// A particle, or a body with a surface.
struct Picked {
  std::size_t body = 0;
  std::optional<std::size_t> particle;
  bool operator==(const Picked&) const = default;
};

// Returns the nearest thing that is drawn at a place of the picture, in pixels from its lower left corner, if any.
std::optional<Picked> pick(const Stage& stage, const Session& session, const osg::Vec2d& place);

// Returns all that is known of it now, or nothing where the scene has no such thing any more.
std::optional<PickedLines> describe(const Stage& stage, const Session& session, const Picked& picked);

// Lines in the picture that mark something, each from one place to the next [pixels from the lower left corner].
using Marks = std::vector<std::vector<osg::Vec2d>>;
// Returns a ring around a particle, or the edges of the box around a body; nothing for what is behind the eye.
Marks marks_of(const Stage& stage, const Session& session, const Picked& picked);

}  // namespace palp
