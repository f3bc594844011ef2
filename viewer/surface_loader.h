// Builds the surfaces of a scene in a thread of its own, so that a large mesh never holds up the thread that draws.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "idl/messages.h"
#include "viewer/mesh.h"
#include "viewer/skin.h"

namespace palp {

struct LoadedSurface {
  std::size_t body = 0;  // its place in SceneDescription::bodies
  BodyMesh mesh;
  std::optional<Skin> skin;  // of a soft body: what carries the vertices of mesh.solid, which else is null
};

// Returns the surface of a body that has one, or a skin (mesh.h). spacing: of the particles [m]. Any thread. Nothing of
// it when it is cancelled, or where particles lie so that they cannot carry a skin.
LoadedSurface load_surface(const BodyDescription& body, double spacing, BuildProgress* progress = nullptr);

// One thread calls it.
class SurfaceLoader {
 public:
  SurfaceLoader() = default;
  // Drops what is not built yet; takes milliseconds.
  ~SurfaceLoader() { stop(); }
  SurfaceLoader(const SurfaceLoader&) = delete;
  SurfaceLoader& operator=(const SurfaceLoader&) = delete;

  // Begins with the bodies of this scene, the quickest first, and drops those of the scene before.
  void start(std::shared_ptr<const SceneDescription> scene);
  // Hands over the surfaces that were finished since the last call. Bodies without a surface are passed over.
  std::vector<LoadedSurface> take();

  // True until take() has handed over the last surface.
  bool busy() const { return waiting_ > 0; }
  std::size_t triangles() const { return triangles_; }  // of the whole scene
  double share_done() const;                            // 0 .. 1, by the work that it takes

 private:
  void stop();
  void build(const SceneDescription& scene, const std::vector<std::size_t>& bodies);

  std::size_t waiting_ = 0;  // surfaces that take() has not handed over
  std::size_t triangles_ = 0;
  std::size_t work_ = 0;  // of all bodies, as build_work() counts it
  std::unique_ptr<BuildProgress> progress_ = std::make_unique<BuildProgress>();
  std::mutex mutex_;
  std::vector<LoadedSurface> finished_;  // under mutex_
  std::thread thread_;
};

}  // namespace palp
