#include "sim_server/elastic_store.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

#include "sim_server/point_grid.h"

namespace palp {
namespace {

// Shares of the largest eigenvalue below which a neighbourhood's moment counts as having no extent that way.
constexpr double kFlat = 1e-3;

// What multiplies X_ji so that affine fields have their exact gradient, and onto what the neighbourhood spans.
struct Correction {
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero(), projection = Eigen::Matrix3d::Zero();
};

Correction correct(const Eigen::Matrix3d& moment) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moment);
  Correction c;
  for (int a = 0; a < 3; ++a) {
    const double value = solver.eigenvalues()[a];
    if (!(value > kFlat * solver.eigenvalues()[2])) continue;
    const Eigen::Vector3d n = solver.eigenvectors().col(a);
    c.inverse += n * n.transpose() / value;
    c.projection += n * n.transpose();
  }
  return c;
}

// Wendland C2: -W'(r)/r.
double slope(double r, double H) {
  const double u = std::max(0.0, 1 - r / H);
  return 210 / (EIGEN_PI * std::pow(H, 5)) * u * u * u;
}

}  // namespace

ElasticStore::ElasticStore(const Scene& scene, const Plan& plan) {
  std::vector<std::uint32_t> particle(plan.elastic_count);  // in the scene's order
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    if (plan.force_first[b] >= plan.elastic_count) continue;
    for (std::uint32_t k = 0; k < body.count; ++k) particle[plan.force_first[b] + k] = body.first + k;
  }
  const PeriodicBox box{scene.bounds_min, scene.bounds_max, scene.config.periodic};
  std::vector<Eigen::Vector3d> place(particle.size());
  for (std::size_t i = 0; i < particle.size(); ++i) place[i] = scene.position[particle[i]];
  const PointGrid grid(place, box, plan.support);
  const auto body_of = [&](std::size_t i) -> const Body& { return scene.bodies[scene.body[particle[i]]]; };
  const bool paper = plan.method == Method::paper;
  bool flat = false;
  first.push_back(0);
  std::vector<std::uint32_t> near;
  for (std::uint32_t i = 0; i < particle.size(); ++i) {
    const std::uint32_t from = particle[i], b = scene.body[from];
    const Body& body = body_of(i);
    const bool elastic = body.type == BodyType::elastic;
    rest.push_back(pack(place[i].cast<real>(), static_cast<real>(scene.volume[from])));
    tag.push_back(make_tag(static_cast<Kind>(body.type), body.material, b));
    u.push_back(pack(Vec3(0, 0, 0), 0));
    v.push_back(pack(scene.velocity[from].cast<real>(), 0));
    rotation.push_back(elastic ? Quat::Identity() : Quat(body.orientation.conjugate().cast<real>()));
    near.clear();
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    grid.near(place[i], [&](std::uint32_t j) {
      const Eigen::Vector3d X = box.between(place[j], place[i]);
      const double r = X.norm();
      const bool same = scene.body[particle[j]] == b;
      const bool joined = plan.group[scene.body[particle[j]]] == plan.group[b];
      const bool internal = elastic ? same || (joined && body_of(j).type != BodyType::elastic)
                                    : joined && body_of(j).type == BodyType::elastic;
      if (j == i || !internal || !(r < plan.support) || !(r > 0)) return;
      near.push_back(j);
      moment += scene.volume[particle[j]] * slope(r, plan.support) * X * X.transpose();
    });
    std::sort(near.begin(), near.end());
    neighbor.insert(neighbor.end(), near.begin(), near.end());
    first.push_back(static_cast<std::uint32_t>(neighbor.size()));
    if (paper) continue;
    const Correction c = correct(moment);
    correction.push_back(c.inverse.cast<real>());
    projection.push_back(c.projection.cast<real>());
    flat = flat || (elastic && !c.projection.isIdentity(1e-6));
  }
  if (!flat) projection.clear();
}

}  // namespace palp
