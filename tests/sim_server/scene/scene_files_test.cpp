// Every scene in config/scenes can be read and sampled at every accuracy.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "sim_server/scene/scene.h"

namespace palp::test::scene_files_test {
namespace {

std::vector<std::string> scene_files() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(PALP_SOURCE_DIR "/config/scenes")) {
    if (entry.path().extension() == ".toml") files.push_back(entry.path().string());
  }
  return files;
}

TEST(SceneFiles, SampleAtEveryAccuracy) {
  const std::vector<std::string> files = scene_files();
  ASSERT_GE(files.size(), 8u);
  for (const std::string& file : files) {
    for (const Accuracy accuracy : {Accuracy::fast, Accuracy::balanced, Accuracy::accurate}) {
      SCOPED_TRACE(file + " " + to_string(accuracy));
      SceneOverrides overrides;
      overrides.accuracy = accuracy;
      overrides.solid_particles = true;
      Scene scene;
      ASSERT_NO_THROW(scene = sample_scene(load_scene(file, overrides), 1000000));
      const std::size_t count = scene.position.size();
      EXPECT_EQ(scene.velocity.size(), count);
      EXPECT_EQ(scene.volume.size(), count);
      EXPECT_EQ(scene.body.size(), count);
      EXPECT_GT(count, 100u);
      EXPECT_LT(count, 120000u);
      for (const Body& body : scene.bodies) {
        const bool deforms = body.type == BodyKind::fluid || body.type == BodyKind::elastic;
        EXPECT_EQ(body.surface.triangles.empty(), deforms) << body.name;
        EXPECT_TRUE(body.count > 0 || !deforms) << body.name;  // a wall may be too thin for particles
        if (body.count > 0) {
          EXPECT_EQ(scene.body[body.first], scene.body[body.first + body.count - 1]);
        }
      }
    }
  }
}

}  // namespace
}  // namespace palp::test::scene_files_test
