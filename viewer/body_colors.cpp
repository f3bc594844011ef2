#include "viewer/body_colors.h"

#include <algorithm>
#include <array>
#include <span>

#include "config/looks.h"

namespace palp {
namespace {

using Color = std::array<float, 3>;

// Colours that keep apart for eyes that see less of red and green, by how a kind of body usually looks. The first of
// the fluids is the one that a material without a colour has.
constexpr Color kFluids[] = {
    {0.30f, 0.50f, 0.90f}, {0.94f, 0.65f, 0.20f}, {0.35f, 0.75f, 0.70f}, {0.80f, 0.45f, 0.65f}};
constexpr Color kSoft[] = {{0.95f, 0.84f, 0.50f}, {0.85f, 0.42f, 0.40f}, {0.60f, 0.78f, 0.45f}, {0.72f, 0.60f, 0.86f}};
constexpr Color kTools[] = {{0.80f, 0.52f, 0.25f}, {0.62f, 0.66f, 0.72f}, {0.36f, 0.58f, 0.52f}, {0.66f, 0.38f, 0.34f}};
constexpr Color kFixed[] = {{0.55f, 0.57f, 0.60f}, {0.72f, 0.68f, 0.60f}, {0.44f, 0.48f, 0.54f}};

std::span<const Color> colors_of(BodyKind kind) {
  switch (kind) {
    case BodyKind::fluid:
      return kFluids;
    case BodyKind::elastic:
      return kSoft;
    case BodyKind::rigid:
      return kTools;
    default:
      return kFixed;
  }
}

}  // namespace

std::shared_ptr<const SceneDescription> with_distinct_colors(std::shared_ptr<const SceneDescription> scene) {
  const Color none = kNoColor;
  if (std::ranges::none_of(scene->bodies, [&](const BodyDescription& body) { return body.color == none; }))
    return scene;
  auto colored = std::make_shared<SceneDescription>(*scene);
  std::array<std::size_t, kBodyKindNames.size()> used{};
  for (BodyDescription& body : colored->bodies) {
    if (body.color != none) continue;
    const std::span<const Color> colors = colors_of(body.kind);
    std::size_t& next = used[std::min(static_cast<std::size_t>(body.kind), used.size() - 1)];
    body.color = colors[next++ % colors.size()];
    if (body.look.clear) body.look.absorption_per_m = absorption_of(body.color);
    if (body.changed_color != none) continue;
    body.changed_color = body.color;
    if (body.changed_look.clear) body.changed_look.absorption_per_m = absorption_of(body.color);
  }
  return colored;
}

}  // namespace palp
