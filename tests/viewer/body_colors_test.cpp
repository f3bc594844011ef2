// Colours for bodies to which the scene gives none.
#include "viewer/body_colors.h"

#include <gtest/gtest.h>

#include <set>

#include "config/scene_config.h"

namespace palp::test {
namespace {

BodyDescription body(BodyKind kind, std::array<float, 3> color) {
  BodyDescription b;
  b.kind = kind;
  b.color = color;
  return b;
}

TEST(BodyColors, BodiesWithoutOneCanBeToldApart) {
  const auto none = kNoColor;
  auto scene = std::make_shared<SceneDescription>();
  for (const BodyKind kind :
       {BodyKind::fixed, BodyKind::rigid, BodyKind::rigid, BodyKind::elastic, BodyKind::fluid, BodyKind::fluid})
    scene->bodies.push_back(body(kind, none));
  const auto colored = with_distinct_colors(scene);
  std::set<std::array<float, 3>> colors;
  for (const BodyDescription& b : colored->bodies) colors.insert(b.color);
  EXPECT_EQ(colors.size(), scene->bodies.size());
  EXPECT_EQ(colored->bodies[4].color, none) << "a fluid by itself stays as blue as it was";
}

TEST(BodyColors, ColorsOfTheSceneStay) {
  auto scene = std::make_shared<SceneDescription>();
  scene->bodies = {body(BodyKind::rigid, {1, 0, 0}), body(BodyKind::fluid, {0, 1, 0})};
  EXPECT_EQ(with_distinct_colors(scene), scene) << "nothing is copied";
  scene->bodies.push_back(body(BodyKind::elastic, kNoColor));
  const auto colored = with_distinct_colors(scene);
  EXPECT_EQ(colored->bodies[0].color, scene->bodies[0].color);
  EXPECT_EQ(colored->bodies[1].color, scene->bodies[1].color);
  EXPECT_NE(colored->bodies[2].color, scene->bodies[2].color);
}

}  // namespace
}  // namespace palp::test
