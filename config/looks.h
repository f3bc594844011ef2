// The looks of a scene's materials: those that a file may name, and what follows from a body's physics where it names
// none.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/scene_config.h"
#include "config/toml_reader.h"
#include "idl/look.h"

namespace palp {

struct ColoredLook {
  std::array<float, 3> color;  // sRGB
  Look look;
};

// Reads a key that holds a look: a name or a table.
std::optional<LookConfig> read_look(TomlTable& table, const char* key);

// Throws ConfigError where a material has a changed look and never changes state.
void check_changed_look(const MaterialConfig& material);

// Returns the names that a file may say, in the order of their table.
std::vector<std::string> look_names();

// Returns the look of that name, in its own colour. Throws std::logic_error when there is none.
ColoredLook named_look(std::string_view name);

// Returns the name of the look that follows from the kind of a body and the physics of its material.
std::string_view usual_look(BodyKind kind, const MaterialConfig& material);

// Returns how a body of that kind and material looks. own_look and own_color, where the body gives them, win over its
// material's. A colour, from wherever, gives what is clear its absorption, unless a look says that; where nothing names
// look or colour, the colour is kNoColor.
ColoredLook look_of(BodyKind kind, const MaterialConfig& material, const std::optional<LookConfig>& own_look = {},
                    const std::optional<std::array<float, 3>>& own_color = {});

// Returns how matter of a body of that kind, which looks like own at first, looks when it has changed state: cooked or
// frozen fluid, molten solid. What is clear stays clear, and what is opaque opaque. Where it never changes state, own.
ColoredLook changed_look_of(BodyKind kind, const MaterialConfig& material, const ColoredLook& own);

// Returns the absorption [1/m] of what is clear and gives white light that sRGB colour over kColorDepth.
std::array<float, 3> absorption_of(const std::array<float, 3>& color);
inline constexpr float kColorDepth = 0.1f;  // [m]

}  // namespace palp
