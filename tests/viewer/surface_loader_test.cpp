// Surfaces that are built beside the thread that draws.
#include "viewer/surface_loader.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/viewer/synthetic_scene.h"

namespace palp::test {
namespace {

using namespace std::chrono_literals;

std::vector<LoadedSurface> wait_for_all(SurfaceLoader& loader) {
  std::vector<LoadedSurface> all;
  for (int i = 0; i < 2000 && loader.busy(); ++i) {
    for (LoadedSurface& surface : loader.take()) all.push_back(std::move(surface));
    std::this_thread::sleep_for(5ms);
  }
  return all;
}

// A surface of so many triangles that it takes seconds.
BodyDescription large_body() {
  BodyDescription body;
  constexpr std::uint32_t kSide = 1500;
  for (std::uint32_t y = 0; y <= kSide; ++y) {
    for (std::uint32_t x = 0; x <= kSide; ++x) {
      const double bump = 0.01 * std::sin(0.1 * x) * std::cos(0.1 * y);
      for (const double c : {1e-3 * x, 1e-3 * y, bump}) body.vertices.push_back(static_cast<float>(c));
      if (x == kSide || y == kSide) continue;
      const std::uint32_t a = y * (kSide + 1) + x, b = a + kSide + 1;
      for (const std::uint32_t v : {a, a + 1, b, b, a + 1, b + 1}) body.triangles.push_back(v);
    }
  }
  return body;
}

TEST(SurfaceLoader, HandsOverEveryBodyWithASurface) {
  SurfaceLoader loader;
  EXPECT_FALSE(loader.busy());
  loader.start(std::make_shared<const SceneDescription>(synthetic_scene().scene));
  EXPECT_TRUE(loader.busy());
  std::size_t bodies = 0;
  for (const LoadedSurface& surface : wait_for_all(loader)) {
    EXPECT_TRUE(surface.body == 1 || surface.body == 2) << surface.body;
    EXPECT_TRUE(surface.mesh.solid);
    ++bodies;
  }
  EXPECT_EQ(bodies, 2u);
  EXPECT_FALSE(loader.busy());
  EXPECT_EQ(loader.share_done(), 1);
}

TEST(SurfaceLoader, IsEndedAndBegunAnewInTheMiddleOfALargeSurface) {
  auto large = std::make_shared<SceneDescription>();
  large->bodies = {large_body()};
  SurfaceLoader loader;
  loader.start(large);
  EXPECT_EQ(loader.triangles(), 4'500'000u);
  EXPECT_TRUE(loader.take().empty());
  EXPECT_LT(loader.share_done(), 1);
  loader.start(std::make_shared<const SceneDescription>(synthetic_scene().scene));
  const std::vector<LoadedSurface> surfaces = wait_for_all(loader);
  EXPECT_EQ(surfaces.size(), 2u) << "the surface of the scene before is dropped";
  loader.start(large);
}  // ends the build

}  // namespace
}  // namespace palp::test
