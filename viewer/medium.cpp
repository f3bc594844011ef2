#include "viewer/medium.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>

namespace palp {
namespace {

// Liquids that one does not look through, as parts of names.
constexpr std::array<std::string_view, 18> kOpaqueLiquids{
    "batter", "butter", "chocolate", "cream",   "custard", "dough", "lava",   "melt",    "milk",
    "mud",    "paint",  "paste",     "pudding", "puree",   "sauce", "slurry", "yoghurt", "yogurt"};

}  // namespace

Medium usual_medium(const BodyDescription& body) {
  if (body.kind == BodyKind::elastic) return Medium::opaque;
  if (body.kind != BodyKind::fluid) return Medium::beads;
  std::string name = body.name;
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool opaque =
      std::ranges::any_of(kOpaqueLiquids, [&](std::string_view word) { return name.find(word) != std::string::npos; });
  return opaque ? Medium::opaque : Medium::clear;
}

}  // namespace palp
