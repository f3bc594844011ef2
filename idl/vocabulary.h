// The kinds of bodies, and the scalars of the particles that can be sent and drawn: one enumeration and one table of
// names for each, from the scene file through the kernels to the viewer's legend. Host and device.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palp {

enum class BodyKind : std::uint32_t { fluid = 0, rigid = 1, fixed = 2, elastic = 3 };

// The name of each kind of body in scene files, by value. A body that never moves is `fixed` here, as `static` is a
// word of C++.
inline constexpr std::array<std::string_view, 4> kBodyKindNames{"fluid", "rigid", "static", "elastic"};

// density_error: by how much the density is above that at rest, over that at rest. state: how much of a particle is
// solid, 0 to 1.
enum class ScalarField : std::uint32_t {
  none = 0,
  speed = 1,
  density = 2,
  pressure = 3,
  temperature = 4,
  density_error = 5,
  state = 6
};

struct ScalarFieldRow {
  std::string_view name;  // in scene files and on command lines
  std::string_view unit;  // for people
};

// The name and unit of each scalar, by value.
inline constexpr std::array<ScalarFieldRow, 7> kScalarFields{{{"none", ""},
                                                              {"speed", "m/s"},
                                                              {"density", "kg/m³"},
                                                              {"pressure", "Pa"},
                                                              {"temperature", "K"},
                                                              {"density_error", "share"},
                                                              {"state", "share solid"}}};

constexpr const ScalarFieldRow& row_of(ScalarField field) { return kScalarFields[static_cast<std::size_t>(field)]; }

// Returns the field of that name, or nothing.
constexpr std::optional<ScalarField> scalar_field_from(std::string_view name) {
  for (std::size_t i = 0; i < kScalarFields.size(); ++i)
    if (kScalarFields[i].name == name) return static_cast<ScalarField>(i);
  return std::nullopt;
}

// Returns the names of all fields as a sentence lists them: "none, speed, density ... or state".
inline std::string names_of_scalar_fields() {
  std::string text;
  for (std::size_t i = 0; i < kScalarFields.size(); ++i) {
    if (i > 0) text += i + 1 < kScalarFields.size() ? ", " : " or ";
    text += kScalarFields[i].name;
  }
  return text;
}

}  // namespace palp
