// Volume integrals of solids: volume, first and second moments. They add up, so a body of several parts is their sum.
#pragma once

#include <Eigen/Geometry>

namespace palp {

struct Moments {
  double volume = 0;                                 // [m^3]
  Eigen::Vector3d first = Eigen::Vector3d::Zero();   // integral of x [m^4]
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  // integral of x x^T [m^5]

  Moments& operator+=(const Moments& other) {
    volume += other.volume;
    first += other.first;
    second += other.second;
    return *this;
  }

  Eigen::Vector3d center() const { return first / volume; }

  // Returns the inertia about the centre for unit density [m^5].
  Eigen::Matrix3d inertia() const {
    const Eigen::Matrix3d s = second - first * first.transpose() / volume;
    return s.trace() * Eigen::Matrix3d::Identity() - s;
  }

  // Returns the moments of the same solid with each of its points x moved to pose * x.
  Moments moved(const Eigen::Isometry3d& pose) const {
    const Eigen::Matrix3d r = pose.linear();
    const Eigen::Vector3d t = pose.translation(), rf = r * first;
    return {volume, rf + volume * t,
            r * second * r.transpose() + rf * t.transpose() + t * rf.transpose() + volume * t * t.transpose()};
  }
};

// Return the moments of a solid about its own centre, along its own axes.
inline Moments box_moments(const Eigen::Vector3d& size) {
  const double v = size.prod();
  return {v, Eigen::Vector3d::Zero(), (v / 12 * size.cwiseProduct(size)).asDiagonal()};
}

inline Moments sphere_moments(double radius) {
  const double v = 4.0 / 3.0 * EIGEN_PI * radius * radius * radius;
  return {v, Eigen::Vector3d::Zero(), v * radius * radius / 5 * Eigen::Matrix3d::Identity()};
}

inline Moments cylinder_moments(double radius, double height) {
  const double v = EIGEN_PI * radius * radius * height, across = v * radius * radius / 4;
  return {v, Eigen::Vector3d::Zero(), Eigen::Vector3d(across, across, v * height * height / 12).asDiagonal()};
}

}  // namespace palp
