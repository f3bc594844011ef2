// How numbers are read off the picture: colours and their range, and what is cut away to look inside.
#pragma once

#include <array>
#include <optional>

#include "idl/messages.h"
#include "viewer/clip_plane.h"
#include "viewer/color_map.h"

namespace palp {

struct Reading {
  std::optional<ColorMapKind> map;                                   // none: the one that suits the field
  std::array<std::optional<ValueRange>, kScalarFields.size()> held;  // by field; none: what suits the values
  ClipPlane clip;
  bool operator==(const Reading&) const = default;

  ColorMapKind map_of(ScalarField field) const { return map.value_or(color_map_of(field)); }
  std::optional<ValueRange>& held_of(ScalarField field) { return held[static_cast<std::size_t>(field)]; }
  const std::optional<ValueRange>& held_of(ScalarField field) const { return held[static_cast<std::size_t>(field)]; }
};

}  // namespace palp
