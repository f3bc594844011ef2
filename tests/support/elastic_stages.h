// Evaluates the forces of elastic bodies one at a time, on the host and without moving anything.
#pragma once

#include <functional>
#include <vector>

#include "sim_server/physics/tear.h"
#include "sim_server/solver/constants.h"
#include "sim_server/solver/elastic_store.h"
#include "sim_server/solver/particle_store.h"
#include "tests/support/scenes.h"

namespace palp::test {

// The elastic stages of a scene on the host, with whatever displacements a test asks for.
class Elastic {
 public:
  explicit Elastic(const Scene& scene, bool hourglass = false)
      : scene_(scene), plan_(make_plan(scene)), store_(scene, plan_), medium_(make_medium(scene, plan_)) {
    for (Material& m : medium_.material)
      if (!hourglass) m.hourglass = 0;
    grid_ = make_grid(scene, plan_);
    const std::size_t n = plan_.elastic_count;
    gradient.resize(n);
    stress_.resize(n);
    force_.resize(n);
    plastic.assign(n, Mat3::Identity());
    hardened.assign(n, real(0));
    torn.assign(store_.neighbor.size(), 0);
    stretch_.assign(n, Packed{0, 0, 0, 0});
    integrity_.assign(n, real(1));
  }

  // x(X), and velocities v(X).
  void deform(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& x,
              const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& v = nullptr) {
    for (std::size_t i = 0; i < store_.rest.size(); ++i) {
      const Eigen::Vector3d X = scene_.position[i];
      store_.u[i] = pack((x(X) - X).cast<real>(), 0);
      if (v) store_.v[i] = pack(v(X).cast<real>(), 0);
    }
  }

  ElasticViews views() {
    ElasticViews e;
    e.count = plan_.elastic_count;
    e.rest = store_.rest.data();
    e.tag = store_.tag.data();
    e.first = store_.first.data();
    e.neighbor = store_.neighbor.data();
    e.correction = store_.correction.data();
    e.projection = store_.projection.empty() ? nullptr : store_.projection.data();
    e.u = store_.u.data();
    e.v = store_.v.data();
    e.rotation = store_.rotation.data();
    e.gradient = gradient.data();
    e.stress = stress_.data();
    e.plastic = plastic.data();
    e.hardened = hardened.data();
    if (plan_.tears) e.torn = torn.data();
    if (plan_.tears) e.stretch = stretch_.data();
    if (plan_.tears) e.integrity = integrity_.data();
    return e;
  }

  std::vector<Eigen::Vector3d> forces() {
    const ElasticViews e = views();
    BodyViews bodies;
    bodies.force = force_.data();
    const auto kernel = WendlandC2::with_support(static_cast<real>(plan_.elastic_support));
    const TearBonds tears{e, grid_, kernel, medium_};
    const ElasticStrain<false> strain{e, bodies, grid_, kernel, medium_};
    const ElasticStrain<true> strain_with_yield{e, bodies, grid_, kernel, medium_};
    const PaperStrain paper{e, bodies, grid_, kernel, medium_};
    for (std::uint32_t i = 0; i < e.count && plan_.tears; ++i) tears(i, SerialTeam{});
    for (std::uint32_t i = 0; i < e.count; ++i)
      if (plan_.plastic)
        strain_with_yield(i, SerialTeam{});
      else if (plan_.method == Method::accurate)
        strain(i, SerialTeam{});
      else
        paper(i, SerialTeam{});
    const ElasticForce force{e, bodies, grid_, kernel, medium_, plan_.method == Method::accurate, false};
    for (std::uint32_t i = 0; i < e.count; ++i) force(i, SerialTeam{});
    std::vector<Eigen::Vector3d> out;
    for (const Packed& f : force_) out.push_back(f.xyz().cast<double>());
    return out;
  }

  const Scene& scene() const { return scene_; }
  const Plan& plan() const { return plan_; }
  const ElasticStore& store() const { return store_; }
  const Medium& medium() const { return medium_; }
  const CellGrid& grid() const { return grid_; }
  // Returns where a particle is, as kernels have it.
  Eigen::Vector3d place(std::size_t i) const {
    return store_.rest[i].xyz().cast<double>() + store_.u[i].xyz().cast<double>();
  }
  std::vector<Mat3> gradient, plastic;
  std::vector<real> hardened;
  std::vector<std::uint8_t> torn;

 private:
  Scene scene_;
  Plan plan_;
  ElasticStore store_;
  Medium medium_;
  CellGrid grid_;
  std::vector<Mat3> stress_;
  std::vector<Packed> force_, stretch_;
  std::vector<real> integrity_;
};

}  // namespace palp::test
