#include "viewer/surface_loader.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "viewer/mirror_images.h"

namespace palp {

LoadedSurface load_surface(const BodyDescription& body, double spacing, BuildProgress* progress) {
  LoadedSurface out;
  const bool soft = has_skin(body);
  out.mesh = build_mesh(body, progress, soft ? spacing : 0);
  if (!soft) out.mesh.images = std::make_shared<MirrorImages>(out.mesh.solid.get(), out.mesh.glass.get(), spacing);
  if (!soft || !out.mesh.solid) return out;
  const auto& vertices = static_cast<const osg::Vec3Array&>(*out.mesh.solid->getVertexArray());
  out.skin = Skin::bind(vertices.asVector(), body.rest, spacing);
  if (!out.skin) out.mesh = {};
  return out;
}

void SurfaceLoader::start(std::shared_ptr<const SceneDescription> scene) {
  stop();
  std::vector<std::size_t> bodies;
  for (std::size_t i = 0; i < scene->bodies.size(); ++i) {
    const BodyDescription& body = scene->bodies[i];
    if (!has_surface(body) && !has_skin(body)) continue;
    bodies.push_back(i);
    work_ += build_work(body);
    triangles_ += body.triangles.size() / 3;
  }
  std::stable_sort(bodies.begin(), bodies.end(), [&](std::size_t a, std::size_t b) {
    return build_work(scene->bodies[a]) < build_work(scene->bodies[b]);
  });
  waiting_ = bodies.size();
  if (bodies.empty()) return;
  thread_ = std::thread([this, scene = std::move(scene), bodies = std::move(bodies)] { build(*scene, bodies); });
}

void SurfaceLoader::build(const SceneDescription& scene, const std::vector<std::size_t>& bodies) {
  for (const std::size_t body : bodies) {
    LoadedSurface surface = load_surface(scene.bodies[body], scene.spacing, progress_.get());
    if (progress_->cancelled) return;
    surface.body = body;
    const std::lock_guard lock(mutex_);
    finished_.push_back(std::move(surface));
  }
}

std::vector<LoadedSurface> SurfaceLoader::take() {
  if (waiting_ == 0) return {};
  std::vector<LoadedSurface> taken;
  {
    const std::lock_guard lock(mutex_);
    taken.swap(finished_);
  }
  waiting_ -= taken.size();
  return taken;
}

double SurfaceLoader::share_done() const {
  if (waiting_ == 0) return 1;
  return std::min(1.0, static_cast<double>(progress_->done) / static_cast<double>(work_));
}

void SurfaceLoader::stop() {
  progress_->cancelled = true;
  if (thread_.joinable()) thread_.join();
  progress_ = std::make_unique<BuildProgress>();
  finished_.clear();
  waiting_ = triangles_ = work_ = 0;
}

}  // namespace palp
