// Random numbers, vectors and orientations, and a test of random cases that prints its seed when it fails.
#pragma once

#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "tests/support/seed.h"

namespace palp::test {

using Random = std::mt19937;

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// Each component from -size to size.
inline Eigen::Vector3d random_vector(Random& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}

inline Eigen::Quaterniond random_rotation(Random& random) {
  std::normal_distribution<double> normal;
  Eigen::Vector4d q;
  for (int k = 0; k < 4; ++k) q[k] = normal(random);
  return Eigen::Quaterniond(q.normalized());
}

class RandomCase : public ::testing::Test {
 protected:
  double between(double low, double high) { return uniform(random_, low, high); }
  Eigen::Vector3d vector(double size) { return random_vector(random_, size); }
  Eigen::Matrix3d matrix(double size) {
    return Eigen::Matrix3d::NullaryExpr([&] { return between(-size, size); });
  }
  Eigen::Matrix3d rotation() { return random_rotation(random_).toRotationMatrix(); }

  const unsigned seed_ = drawn_seed();
  Random random_{seed_};

 private:
  ::testing::ScopedTrace trace_{__FILE__, __LINE__, ::testing::Message() << "seed " << seed_};
};

}  // namespace palp::test
