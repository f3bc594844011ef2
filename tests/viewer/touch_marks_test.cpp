// Where media touch a tool: how its surface is cut, which places count as touched, and what is said of them.
#include "viewer/touch_marks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/viewer/synthetic_scene.h"
#include "viewer/mesh.h"

namespace palp::test::touch_marks_test {
namespace {

constexpr float kDx = 0.01f;  // spacing [m]
constexpr double kHalf = 0.05, kThin = 0.002;

// A plate of 10 cm by 10 cm, thinner than the spacing, whose upper side is at z = 0.
osg::ref_ptr<osg::Geometry> plate() {
  BodyDescription body;
  body.kind = BodyKind::rigid;
  add_box(body, {-kHalf, -kHalf, -kThin}, {kHalf, kHalf, 0}, true, true);
  return build_mesh(body).solid;
}

// A layer of particles at that height over the plate's middle, on a square of this side [m].
ParticleFrame layer(double z, double side, float pressure) {
  ParticleFrame frame;
  frame.field = ScalarField::pressure;
  for (double x = -side / 2 + kDx / 2; x < side / 2; x += kDx) {
    for (double y = -side / 2 + kDx / 2; y < side / 2; y += kDx) {
      for (const double c : {x, y, z}) frame.positions.push_back(static_cast<float>(c));
      frame.scalars.push_back(pressure);
    }
  }
  return frame;
}

const PressureColors kColors{{0, 1000}, ColorMapKind::sequential};
const std::vector<ParticleRange> kAll{{0, 1'000'000}};

class TouchMarksTest : public testing::Test {
 protected:
  TouchMarksTest() { marks_.add_part(*plate()); }
  Touch touch(const ParticleFrame& frame, const PressureColors* colors = &kColors) {
    return marks_.set(frame, kAll, osg::Matrixd(), colors);
  }
  TouchMarks marks_{kDx};
};

TEST_F(TouchMarksTest, ALayerHalfASpacingOffTouchesTheSideThatItIsOn) {
  const Touch touched = touch(layer(0.5 * kDx, 0.04, 300));
  // the square and what is within a spacing around it
  EXPECT_GT(touched.area, 0.04 * 0.04);
  EXPECT_LT(touched.area, 0.06 * 0.06);
  EXPECT_NEAR(touched.pressure.value(), 300, 0.01);
  for (std::size_t v = 0; v < marks_.surface().vertices.size(); ++v) {
    const osg::Vec3f& at = marks_.surface().vertices[v];
    const double outside = std::max(std::abs(at.x()), std::abs(at.y())) - 0.02;
    const bool above = marks_.normals()[v].z() > 0;
    if ((!above && at.z() < 0) || outside > 1.2 * kDx) {
      EXPECT_EQ(marks_.touched()[v], 0) << "below the plate, or beside the layer";
    }
    if (above && outside < -kDx / 2) {
      EXPECT_EQ(marks_.touched()[v], 1) << "between particles as below them";
    }
  }
}

TEST_F(TouchMarksTest, WhatIsFartherThanItsLayerDoesNotTouch) {
  EXPECT_EQ(touch(layer(1.5 * kDx, 0.04, 300)).area, 0);
  EXPECT_FALSE(touch(layer(1.5 * kDx, 0.04, 300)).pressure);
  EXPECT_EQ(marks_.node()->getNodeMask(), 0u);
  const double whole = touch(layer(0.5 * kDx, 0.04, 300)).area, fading = touch(layer(1.05 * kDx, 0.04, 300)).area;
  EXPECT_GT(fading, 0);
  EXPECT_LT(fading, 0.7 * whole);
}

TEST_F(TouchMarksTest, GoWithTheTool) {
  const osg::Matrixd pose = osg::Matrixd::rotate(0.7, osg::Vec3d(1, 2, 3)) * osg::Matrixd::translate(0.3, -2, 5);
  ParticleFrame frame = layer(0.5 * kDx, 0.04, 300);
  const double area = touch(frame).area;
  for (std::size_t i = 0; i < frame.positions.size(); i += 3) {
    const osg::Vec3d p = osg::Vec3d(frame.positions[i], frame.positions[i + 1], frame.positions[i + 2]) * pose;
    for (int k = 0; k < 3; ++k) frame.positions[i + static_cast<std::size_t>(k)] = static_cast<float>(p[k]);
  }
  EXPECT_EQ(touch(frame).area, 0);
  EXPECT_NEAR(marks_.set(frame, kAll, pose, &kColors).area, area, 0.01 * area);
}

TEST_F(TouchMarksTest, PressuresAreThoseOfTheParticlesNearby) {
  ParticleFrame frame = layer(0.5 * kDx, 0.04, 100);
  for (std::size_t i = 0; i < frame.scalars.size(); ++i)
    if (frame.positions[3 * i] > 0) frame.scalars[i] = 700;
  EXPECT_NEAR(touch(frame).pressure.value(), 400, 10);
  EXPECT_FALSE(touch(frame, nullptr).pressure) << "the scalars are no pressures";
  EXPECT_GT(touch(frame, nullptr).area, 0);
  frame.scalars.clear();
  EXPECT_FALSE(touch(frame).pressure);
}

TEST_F(TouchMarksTest, OnlyTheRangesCountAndNothingSenselessDoes) {
  const ParticleFrame frame = layer(0.5 * kDx, 0.04, 300);
  const auto count = static_cast<std::uint32_t>(frame.scalars.size());
  EXPECT_EQ(marks_.set(frame, {}, osg::Matrixd(), &kColors).area, 0);
  const std::vector<ParticleRange> beyond{{count, 5}, {~0u, ~0u}};
  EXPECT_EQ(marks_.set(frame, beyond, osg::Matrixd(), &kColors).area, 0);
  ParticleFrame bad = frame;
  for (std::size_t i = 0; i < bad.scalars.size(); ++i) {
    bad.positions[3 * i + i % 3] = i % 2 != 0 ? std::nanf("") : std::numeric_limits<float>::infinity();
  }
  EXPECT_EQ(touch(bad).area, 0);
  bad = frame;
  bad.scalars.assign(count, std::nanf(""));
  EXPECT_EQ(touch(bad).area, 0);
}

}  // namespace
}  // namespace palp::test::touch_marks_test
