// Looking at pictures in tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <osg/Image>
#include <osg/Vec2d>
#include <osgDB/WriteFile>

#include "viewer/stage.h"
#include "viewer/surface_loader.h"

namespace palp::test {

struct Pixel {
  int r = 0, g = 0, b = 0;
};

inline Pixel at(const Picture& picture, int x, int y) {
  x = std::clamp(x, 0, picture.width - 1);
  y = std::clamp(y, 0, picture.height - 1);
  const std::uint8_t* p = picture.rgb.data() + 3 * (static_cast<std::size_t>(y) * picture.width + x);
  return {p[0], p[1], p[2]};
}

inline Pixel at(const Picture& picture, const osg::Vec2d& p) {
  return at(picture, static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())));
}

struct Spot {
  int pixels = 0;
  osg::Vec2d middle;  // centroid
  double radius = 0;  // of a disc of that many pixels
};

inline Spot find(const Picture& picture, const std::function<bool(Pixel)>& wanted) {
  Spot spot;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (!wanted(at(picture, x, y))) continue;
      ++spot.pixels;
      spot.middle += osg::Vec2d(x + 0.5, y + 0.5);
    }
  }
  if (spot.pixels > 0) spot.middle /= spot.pixels;
  spot.radius = std::sqrt(spot.pixels / M_PI);
  return spot;
}

inline bool reddish(Pixel p) { return p.r > 60 && p.r > 2 * p.g && p.r > 2 * p.b; }
inline bool greenish(Pixel p) { return p.g > 60 && p.g > 2 * p.r && p.g > 2 * p.b; }
inline bool bluish(Pixel p) { return p.b > 60 && p.b > 2 * p.r && p.b > 2 * p.g; }
// the force arrow
inline bool orange(Pixel p) { return p.r > 120 && p.r > p.g + 40 && p.g > p.b + 25; }

// Pixels that differ at all.
inline int differing(const Picture& a, const Picture& b) {
  int count = 0;
  for (std::size_t i = 0; i + 2 < a.rgb.size() && i + 2 < b.rgb.size(); i += 3) {
    count += a.rgb[i] != b.rgb[i] || a.rgb[i + 1] != b.rgb[i + 1] || a.rgb[i + 2] != b.rgb[i + 2];
  }
  return count;
}

// Returns how far places are from the straight line through them [root mean square, along y].
inline double off_line(const std::vector<osg::Vec2d>& places) {
  const auto n = static_cast<double>(places.size());
  double x1 = 0, y1 = 0, x2 = 0, xy = 0, y2 = 0;
  for (const osg::Vec2d& p : places)
    x1 += p.x(), y1 += p.y(), x2 += p.x() * p.x(), xy += p.x() * p.y(), y2 += p.y() * p.y();
  const double slope = (xy - x1 * y1 / n) / (x2 - x1 * x1 / n);
  return std::sqrt(std::max(0.0, (y2 - y1 * y1 / n - slope * (xy - x1 * y1 / n)) / n));
}

inline StageOptions small_stage(int width = 320, int height = 240) {
  StageOptions options;
  options.width = width;
  options.height = height;
  options.headless = true;
  options.gpu = "cpu";
  options.on_gl_error = [](const std::string& error) { ADD_FAILURE() << "OpenGL: " << error; };
  return options;
}

// Shows a scene with its surfaces, which the viewer builds beside the pictures.
inline void set_scene(Stage& stage, const SceneDescription& scene) {
  stage.scene().set_scene(scene);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    LoadedSurface loaded = load_surface(scene.bodies[i], scene.spacing);
    if (loaded.skin)
      stage.scene().set_soft_surface(i, loaded.mesh, std::move(*loaded.skin));
    else
      stage.scene().set_surface(i, loaded.mesh);
  }
}

inline Picture shoot(Stage& stage) {
  Picture picture;
  stage.draw([&](Picture&& taken) { picture = std::move(taken); });
  // for people who want to look: PALP_TEST_PICTURES=DIRECTORY keeps every picture
  if (const char* directory = std::getenv("PALP_TEST_PICTURES")) {
    static int count = 0;
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    osg::ref_ptr<osg::Image> image = new osg::Image;
    image->setImage(picture.width, picture.height, 1, GL_RGB, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data(),
                    osg::Image::NO_DELETE, 1);
    osgDB::writeImageFile(*image, std::string(directory) + "/" + test->name() + std::to_string(count++) + ".png");
  }
  return picture;
}

}  // namespace palp::test
