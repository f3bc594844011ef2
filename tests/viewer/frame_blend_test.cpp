// Tests what is shown between two recorded frames.
#include "viewer/frame_blend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace palp::test {
namespace {

ParticleFrame frame(double time, std::vector<float> positions, std::vector<float> scalars = {}) {
  ParticleFrame out;
  out.sim_time = time;
  out.positions = std::move(positions);
  out.scalars = std::move(scalars);
  out.field = out.scalars.empty() ? ScalarField::none : ScalarField::speed;
  return out;
}

TEST(FrameBlend, LiesStraightBetween) {
  const ParticleFrame a = frame(1, {0, 0, 0, 0.1f, 0.2f, 0.3f}, {0, 10}),
                      b = frame(1.5, {1, 0, 0, 0.1f, 0.2f, 0.1f}, {4, 10});
  const ParticleFrame middle = between(a, b, 1.125);
  EXPECT_FLOAT_EQ(middle.positions[0], 0.25f);
  EXPECT_FLOAT_EQ(middle.positions[5], 0.25f);
  EXPECT_FLOAT_EQ(middle.scalars[0], 1);
  EXPECT_EQ(middle.sim_time, 1.125);
  EXPECT_EQ(between(a, b, 1).positions, a.positions);
  EXPECT_FLOAT_EQ(between(a, b, 9).positions[0], 1);
}

TEST(FrameBlend, MeltsEvenly) {
  ParticleFrame a = frame(0, {0, 0, 0, 1, 1, 1}), b = frame(1, {0, 0, 0, 1, 1, 1});
  a.solid = {255, 0};
  b.solid = {0, 100};
  EXPECT_EQ(between(a, b, 0.25).solid, (std::vector<std::uint8_t>{191, 25}));
  b.solid.clear();
  EXPECT_EQ(between(a, b, 0.25).solid, a.solid);
}

TEST(FrameBlend, WhatWasPutElsewhereOrIsNoNumberHarmsNoOther) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const ParticleFrame a = frame(0, {0, 0, 0, 0, 0, 0, 0, 0, 0}), b = frame(0.01, {9, 0, 0, nan, 0, 0, 0.02f, 0, 0});
  const ParticleFrame middle = between(a, b, 0.005);
  EXPECT_EQ(middle.positions, (std::vector<float>{0, 0, 0, 0, 0, 0, 0.01f, 0, 0}));
}

TEST(FrameBlend, FramesOfOtherParticlesOrFieldsAreNotMixed) {
  const ParticleFrame a = frame(0, {0, 0, 0}, {1});
  EXPECT_EQ(between(a, frame(1, {1, 1, 1, 2, 2, 2}, {3, 4}), 0.5).positions, a.positions);
  ParticleFrame other = frame(1, {0, 0, 0}, {3});
  other.field = ScalarField::pressure;
  EXPECT_EQ(between(a, other, 0.5).scalars, a.scalars);
}

TEST(FrameBlend, BodiesTurnEvenly) {
  BodyPoses a, b;
  a.sim_time = 0;
  b.sim_time = 0.1;
  a.body = b.body = {1, 4};
  const double half = std::sqrt(0.5);
  a.pose = {{{0, 0, 0}, {0, 0, 0, 1}}, {{1, 0, 0}, {0, 0, 0, 1}}};
  b.pose = {{{0.2, 0, 0}, {0, 0, half, half}}, {{1, 0, 0}, {0, 0, 0, 1}}};  // a quarter turn about z
  const BodyPoses middle = between(a, b, 0.05);
  EXPECT_NEAR(middle.pose[0].position[0], 0.1, 1e-12);
  EXPECT_NEAR(middle.pose[0].orientation[2], std::sin(M_PI / 8), 1e-12);
  EXPECT_EQ(middle.pose[1], a.pose[1]);
  EXPECT_EQ(middle.sim_time, 0.05);
  b.body = {1, 5};
  EXPECT_EQ(between(a, b, 0.05).pose[1], a.pose[1]);
}

}  // namespace
}  // namespace palp::test
