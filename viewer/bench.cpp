#include "viewer/bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>
#include <osg/NodeVisitor>
#include <osg/Program>

#include "viewer/draw_times.h"

namespace palp {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t kFewestPictures = 10;  // pictures that a median is of
constexpr std::size_t kWarmUp = 3;           // pictures in which shaders are compiled and textures made
constexpr double kSpacing = 0.01;            // [m]
constexpr std::size_t kFrames = 4;           // of the waves, which take turns
const std::string kWholePicture = "picture";

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Three times as long and twice as wide as deep, as far as whole layers go.
struct Pool {
  std::size_t nx, ny, n;
  explicit Pool(std::size_t particles) : n(particles) {
    const double depth = std::cbrt(static_cast<double>(particles) / 6);
    ny = std::max<std::size_t>(1, std::lround(2 * depth));
    nx = std::max<std::size_t>(1, std::lround(3 * depth));
  }
};

SceneDescription describe(const Pool& pool, Medium medium) {
  SceneDescription scene;
  scene.name = "benchmark";
  scene.spacing = kSpacing;
  scene.support_radius = 3 * kSpacing;
  scene.haptic_rate_hz = 1000;
  scene.particle_count = static_cast<std::uint32_t>(pool.n);
  const double reach = kSpacing * static_cast<double>(pool.nx);
  scene.bounds_min = {-reach, -reach, -reach};
  scene.bounds_max = {reach, reach, reach};
  BodyDescription water;
  water.name = "water";
  water.count = scene.particle_count;
  water.density = 1000;
  water.color = {0.20f, 0.52f, 0.86f};
  water.look.clear = medium == Medium::clear;
  water.look.absorption_per_m = {2, 1, 0.5f};
  water.look.scattering_length = kMostScatteringLength;
  water.look.foam = 1;
  scene.bodies = {water};
  return scene;
}

// A lattice, disturbed as fluids are, beneath a wave. phase [rad].
ParticleFrame frame_of(const Pool& pool, double phase) {
  ParticleFrame frame;
  frame.field = ScalarField::none;
  frame.positions.reserve(3 * pool.n);
  for (std::size_t i = 0; i < pool.n; ++i) {
    const std::size_t x = i % pool.nx, y = i / pool.nx % pool.ny, z = i / (pool.nx * pool.ny);
    const double at = 6 * M_PI * static_cast<double>(x) / static_cast<double>(pool.nx);
    const double lift = 1.5 * std::sin(at + phase), k = static_cast<double>(i);
    frame.positions.push_back(static_cast<float>(
        kSpacing * (static_cast<double>(x) - 0.5 * static_cast<double>(pool.nx) + 0.15 * std::sin(7919 * k))));
    frame.positions.push_back(static_cast<float>(
        kSpacing * (static_cast<double>(y) - 0.5 * static_cast<double>(pool.ny) + 0.15 * std::sin(104729 * k))));
    frame.positions.push_back(
        static_cast<float>(kSpacing * (static_cast<double>(z) + lift + 0.15 * std::sin(1299709 * k))));
  }
  return frame;
}

// The time between two moments of a camera, OpenGL's work included.
class PassClock {
 public:
  explicit PassClock(std::string name) : name_(std::move(name)) {}
  void begin() {
    glFinish();
    begun_ = Clock::now();
  }
  void end() {
    glFinish();
    sum_ += ms_since(begun_);
  }
  const std::string& name() const { return name_; }
  // Returns the time since the last call [ms].
  double take() { return std::exchange(sum_, 0); }

 private:
  std::string name_;
  Clock::time_point begun_;
  double sum_ = 0;
};

struct Begin : osg::Camera::DrawCallback {
  explicit Begin(PassClock& to) : clock(to) {}
  void operator()(osg::RenderInfo& /*unused*/) const override { clock.begin(); }
  PassClock& clock;  // of a Stopwatch, which takes this callback off before it ends
};

struct End : osg::Camera::DrawCallback {
  explicit End(PassClock& to) : clock(to) {}
  void operator()(osg::RenderInfo& /*unused*/) const override { clock.end(); }
  PassClock& clock;
};

// Finds the cameras that draw into textures: the passes. Each has the name of its program.
class FindPasses : public osg::NodeVisitor {
 public:
  FindPasses() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
  void apply(osg::Camera& camera) override {
    if (camera.getRenderOrder() == osg::Camera::PRE_RENDER) found.push_back(&camera);
    traverse(camera);
  }
  std::vector<osg::Camera*> found;
};

std::string name_of(const osg::Camera& pass) {
  const osg::StateAttribute* program =
      pass.getStateSet() != nullptr ? pass.getStateSet()->getAttribute(osg::StateAttribute::PROGRAM) : nullptr;
  return program != nullptr && !program->getName().empty() ? program->getName() : "other passes";
}

// Draws one picture and waits until OpenGL has done it [ms].
double draw_wholly(Stage& stage) {
  osg::GraphicsContext* context = stage.viewer().getCamera()->getGraphicsContext();
  const auto start = Clock::now();
  stage.draw();
  context->makeCurrent();
  glFinish();
  const double took = ms_since(start);
  context->releaseContext();
  return took;
}

// Clocks for the passes of the scene, for as long as this lives.
class Stopwatch {
 public:
  explicit Stopwatch(Stage& stage) {
    FindPasses passes;
    stage.viewer().getSceneData()->accept(passes);
    passes_ = passes.found;
    clocks_.reserve(passes_.size());
    for (osg::Camera* pass : passes_) {
      PassClock& clock = clocks_.emplace_back(name_of(*pass));
      pass->setInitialDrawCallback(new Begin(clock));
      pass->setFinalDrawCallback(new End(clock));
    }
  }
  ~Stopwatch() {
    for (osg::Camera* pass : passes_) {
      pass->setInitialDrawCallback(nullptr);
      pass->setFinalDrawCallback(nullptr);
    }
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

  // Returns what passes took since the last call, by name [ms].
  std::map<std::string, double> take() {
    std::map<std::string, double> took;
    for (PassClock& clock : clocks_) took[clock.name()] += clock.take();
    return took;
  }

 private:
  std::vector<osg::Camera*> passes_;
  std::vector<PassClock> clocks_;
};

}  // namespace

DrawingTimes time_drawing(Stage& stage, std::size_t particles, Medium medium, double seconds) {
  const Pool pool(particles);
  std::vector<ParticleFrame> frames;
  for (std::size_t k = 0; k < kFrames; ++k)
    frames.push_back(frame_of(pool, 2 * M_PI * static_cast<double>(k) / kFrames));
  stage.scene().set_scene(describe(pool, medium));
  stage.scene().set_beads(medium == Medium::beads);
  stage.scene().set_frame(frames[0]);
  stage.go_home();
  for (std::size_t k = 0; k < kWarmUp; ++k) draw_wholly(stage);

  DrawTimes takes, pictures;
  const auto start = Clock::now();
  while (pictures.count() < kFewestPictures || ms_since(start) < 500 * seconds) {
    const auto begun = Clock::now();
    stage.scene().set_frame(frames[pictures.count() % kFrames]);
    takes.add(1e-3 * ms_since(begun));
    pictures.add(1e-3 * draw_wholly(stage));
  }

  std::map<std::string, DrawTimes> passes;
  Stopwatch stopwatch(stage);
  const auto again = Clock::now();
  for (std::size_t k = 0; k < kFewestPictures || ms_since(again) < 500 * seconds; ++k) {
    stage.scene().set_frame(frames[k % kFrames]);
    double rest = draw_wholly(stage);
    for (const auto& [name, took] : stopwatch.take()) {
      passes[name].add(1e-3 * took);
      rest -= took;
    }
    passes[kWholePicture].add(1e-3 * rest);
  }

  DrawingTimes times{particles,
                     stage.scene().cloud().seen(),
                     pictures.count(),
                     takes.share_ms(0.5),
                     pictures.share_ms(0.5),
                     pictures.share_ms(0.99),
                     {}};
  for (const auto& [name, took] : passes) times.passes[name] = took.share_ms(0.5);
  stage.scene().set_frame(frames[0]);
  return times;
}

std::string table_of(const DrawingTimes& times) {
  std::string table =
      fmt::format("{} particles, {} of them seen, {} pictures\n", times.particles, times.seen, times.pictures);
  const auto row = [&](const std::string& what, double ms) { table += fmt::format("{:<36} {:9.2f} ms\n", what, ms); };
  row("taking over a frame", times.take);
  row("a picture", times.picture);
  row("a picture, slowest of a hundred", times.slowest);
  table += "by pass, each waited for:\n";
  for (const auto& [name, ms] : times.passes)
    if (ms > 0.005) row("  " + (name == kWholePicture ? "the picture itself" : name), ms);
  return table;
}

}  // namespace palp
