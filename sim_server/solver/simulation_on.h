// The simulation on one back end: owns the arrays that the plan names, carries states in and results out.
//
// Flow of a step: input block to the device -> sub-steps (step.h) -> body states and health back -> one wait.
#pragma once

#include <atomic>
#include <chrono>
#include <cmath>

#include "sim_server/physics/pack_frame.h"
#include "sim_server/solver/changeable_parameters.h"
#include "sim_server/solver/module_arrays.h"
#include "sim_server/solver/particle_store.h"
#include "sim_server/solver/scene_warnings.h"
#include "sim_server/solver/simulation.h"
#include "sim_server/solver/step.h"
#include "sim_server/solver/step_results.h"

namespace palp {

template <class B>
class SimulationOn final : public Simulation {
 public:
  explicit SimulationOn(const Scene& scene)
      : scene_(scene),
        plan_(make_plan(scene, B::kSkinOverSpacing, B::kCellsPerReach)),
        warnings_(scene_warnings(scene_, plan_)),
        results_(scene_, plan_),
        back_end_(scene.position.size()) {
    allocate();
    reset();
  }

  const Scene& scene() const override { return scene_; }
  std::string backend_name() const override { return back_end_.name(); }
  std::string gpu() const override { return back_end_.gpu(); }
  void take_gpu() override { back_end_.take_gpu(); }
  std::string numerics() const override { return describe(plan_, scene_); }

  double support_radius() const override { return plan_.support; }
  int sub_steps() const override { return plan_.sub_steps; }
  int fluid_interval() const override { return plan_.fluid_interval; }

  void set_parameter(const std::string& name, const std::string& value) override {
    SceneConfig config = scene_.config;
    apply_parameter(config, name, value);
    // pressure is the fluid's state, so the sound speed that gives it its meaning stays
    const NumericsConfig numerics = config.numerics;
    config.numerics.sound_speed = plan_.sound_speed;
    config.numerics.max_speed = plan_.max_speed;
    config.numerics.tension = plan_.tension;
    config.numerics.shift = plan_.shift;  // its arrays are there, or not
    if (plan_.elastic)                    // its arrays were allocated for one of the two
      config.numerics.elastic_solver = plan_.elastic_rounds > 0 ? ElasticSolver::implicit : ElasticSolver::explicit_;
    std::swap(scene_.config, config);
    try {
      plan_ = make_plan(scene_, B::kSkinOverSpacing, B::kCellsPerReach);
    } catch (...) {
      std::swap(scene_.config, config);
      throw;
    }
    scene_.config.numerics = numerics;
    views_.medium = make_medium(scene_, plan_);
    views_.fluid.cohesion = make_cohesion_medium(scene_, plan_);
    if (plan_.viscous_stages > 0) allocate_viscosity(back_end_, scene_, plan_, views_.fluid.viscosity);
    if (plan_.heat) views_.heat.medium = make_heat_medium(scene_, plan_);
    if (plan_.change) views_.change.medium = make_change_medium(scene_, plan_);
    results_.disturb();
    back_end_.forget();
  }

  const StepOutput& step(const StepInput& input) override {
    results_.fill(input, output_.time, *input_.host);
    // variants: fluids stay, if they ever do; they move; and all stages run, if some are seldom
    const bool varies = plan_.heat || plan_.sleeps || plan_.shifts;
    const int at_once = plan_.fluid_interval, resting = at_once > 1 ? 1 : 0, variants = resting + (varies ? 2 : 1);
    const auto due = [this](int from, int every) {
      return (output_.step + static_cast<unsigned>(from)) % static_cast<unsigned>(every) == 0;
    };
    const bool first = plan_.shifts && output_.step < static_cast<unsigned>(kFirstLooks * at_once);
    const int moving = resting + (varies && (first || due(at_once, interval())) ? 1 : 0);
    back_end_.execute(due(0, at_once) ? moving : 0, variants, [&](int variant) {
      back_end_.push(input_);
      palp::step(back_end_, plan_, views_, {variant >= resting, varies && variant + 1 == variants});
      if (plan_.wrench) back_end_.pull(bodies_);
      back_end_.pull(health_);
    });
    ++output_.step;
    output_.time = static_cast<double>(output_.step) / scene_.config.rate_hz;
    results_.read(bodies_.host, *health_.host, back_end_.neighbor_overflow(), output_);
    return output_;
  }

  const StepOutput& output() const override { return output_; }

  void reset() override {
    const ParticleStore store(scene_, plan_);
    const ParticleView& s = views_.state;
    back_end_.upload(s.xV, store.xV);
    back_end_.upload(s.vp, store.vp);
    back_end_.upload(s.mass, store.mass);
    back_end_.upload(s.tag, store.tag);
    back_end_.upload(s.id, store.id);
    if (plan_.temperature) back_end_.upload(s.temperature, store.temperature);
    if (plan_.heat) back_end_.upload(s.enthalpy, store.enthalpy);
    if (plan_.shifts) back_end_.upload(s.smooth, std::vector<Packed>(scene_.position.size(), Packed{0, 0, 0, 0}));
    if (plan_.wrench) back_end_.upload(views_.body.local, store.local);
    if (plan_.elastic) reset_elastic(back_end_, scene_, plan_, views_.elastic);
    if (plan_.elastic_rounds > 0) reset_implicit(back_end_, plan_, views_.implicit);
    if (plan_.fields) reset_contact(back_end_, contact_counts_, views_.contact);
    if (plan_.change) reset_change(back_end_, scene_, plan_, views_);
    if (plan_.sleeps) reset_sleep(back_end_, scene_, plan_, views_);
    if (plan_.solids) back_end_.upload(views_.body.body, store.bodies);
    if (views_.fluid.walls.open != nullptr)
      back_end_.for_each("open cells", views_.grid.cells(),
                         MarkOpenCells{views_.body.body, views_.fluid.walls, views_.grid, views_.medium});
    results_.reset(store.bodies, output_);
  }

  void snapshot(Snapshot& out) override {
    ParticleStore store(scene_, plan_);
    const ParticleView& s = views_.state;
    back_end_.download(store.xV, s.xV);
    back_end_.download(store.vp, s.vp);
    back_end_.download(store.tag, s.tag);
    back_end_.download(store.id, s.id);
    if (plan_.temperature) back_end_.download(store.temperature, s.temperature);
    store.scatter(views_.medium, out);
    if (plan_.heat) {
      const std::vector<real> start = store.enthalpy;
      back_end_.download(store.enthalpy, s.enthalpy);
      back_end_.download(store.mass, s.mass);
      store.scatter_heat(start, views_.heat.medium, out);
    }
    if (plan_.elastic) snapshot_elastic(back_end_, scene_, plan_, views_, out);
    if (plan_.change) snapshot_change(back_end_, scene_, plan_, views_, store.id, out);
    out.time = output_.time;
    out.support = plan_.support;
  }

  bool begin_frame(ScalarField scalar) override {
    if (frame_state_ != FrameState::idle) return false;
    if (frame_scalar_.device == nullptr && scalar != ScalarField::none)
      frame_scalar_ = back_end_.template mirror<float>("frame scalar", views_.particles);
    if (frame_position_.device == nullptr)
      frame_position_ = back_end_.template mirror<float>("frame position", 3 * std::size_t(views_.particles));
    if (frame_solid_.device == nullptr && plan_.change)
      frame_solid_ = back_end_.template mirror<std::uint8_t>("frame solid", views_.particles);
    back_end_.for_each("frame", views_.particles,
                       PackFrame{views_.state, views_.medium, frame_position_.device, frame_scalar_.device, scalar,
                                 frame_solid_.device});
    back_end_.begin_transfer(frame_position_, scalar == ScalarField::none ? decltype(frame_scalar_){} : frame_scalar_,
                             frame_solid_);
    frame_has_scalar_ = scalar != ScalarField::none;
    frame_time_ = output_.time;
    frame_step_ = output_.step;
    frame_state_ = FrameState::begun;
    return true;
  }

  bool take_frame(Frame& out) override {
    if (frame_state_ != FrameState::begun || !back_end_.transfer_done()) return false;
    out.time = frame_time_;
    out.step = frame_step_;
    out.position.assign(frame_position_.host, frame_position_.host + 3 * std::size_t(views_.particles));
    if (frame_has_scalar_)
      out.scalar.assign(frame_scalar_.host, frame_scalar_.host + views_.particles);
    else
      out.scalar.clear();
    out.solid.assign(frame_solid_.host, frame_solid_.host + frame_solid_.count);
    frame_state_ = FrameState::idle;
    return true;
  }

  Footprint footprint() const override { return {back_end_.arrays(), back_end_.launches()}; }

  StageTimes time_stages(const StepInput& input, double seconds) override {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                     std::chrono::duration<double>(std::clamp(seconds, 0.0, 1e6)));
    StageTimes times;
    back_end_.time_stages(&times);
    do {
      for (int k = 0; k < interval(); ++k) step(input);
      times.steps += static_cast<std::uint64_t>(interval());
    } while (Clock::now() < end);
    back_end_.time_stages(nullptr);
    return times;
  }

  const std::vector<std::string>& warnings() const override { return warnings_; }

 private:
  enum class FrameState { idle, begun };

  // Returns the haptic steps from one to the next of those that have all stages; a scene with heat has no sleep
  // and shifts nothing.
  int interval() const {
    return std::max({plan_.heat_interval, plan_.sleep_interval, plan_.layer_interval, plan_.fluid_interval});
  }

  ParticleView allocate_particles(const std::string& set) {
    const std::size_t n = scene_.position.size();
    ParticleView v;
    if (n == 0) return v;
    v.xV = back_end_.template allocate<Packed>(set + " position", n);
    v.vp = back_end_.template allocate<Packed>(set + " velocity", n);
    v.mass = back_end_.template allocate<real>(set + " mass", n);
    v.tag = back_end_.template allocate<Tag>(set + " tag", n);
    v.id = back_end_.template allocate<std::uint32_t>(set + " id", n);
    if (plan_.temperature) v.temperature = back_end_.template allocate<real>(set + " temperature", n);
    if (plan_.heat) v.enthalpy = back_end_.template allocate<real>(set + " enthalpy", n);
    if (plan_.shifts) v.smooth = back_end_.template allocate<Packed>(set + " smooth slope", n);
    if (plan_.change) v.solid = back_end_.template allocate<Solidity>(set + " solid fraction", n);
    return v;
  }

  void allocate() {
    const std::size_t n = scene_.position.size();
    views_.particles = static_cast<std::uint32_t>(n);
    views_.state = allocate_particles("state");
    views_.grid = make_grid(scene_, plan_);
    views_.grid.tiled = n >= B::kTiledFrom;
    if (plan_.neighbors) {
      const double reach = (plan_.support + plan_.skin) / scene_.spacing;
      views_.sorted = allocate_particles("sorted");
      views_.grid.start =
          back_end_.allocate_sort(views_.particles, views_.grid.cells(), 4.0 / 3.0 * EIGEN_PI * reach * reach * reach);
    }
    views_.medium = make_medium(scene_, plan_);
    views_.fluid.cohesion = make_cohesion_medium(scene_, plan_);
    if (plan_.heat) allocate_heat(back_end_, scene_, plan_, views_);
    if (plan_.viscous_stages > 0) allocate_viscosity(back_end_, scene_, plan_, views_.fluid.viscosity);
    if (plan_.fluid) views_.fluid.acceleration = back_end_.template allocate<Packed>("acceleration", n);
    if (plan_.shifts) views_.fluid.shift_sums = back_end_.template allocate<Packed>("shift sums", n);
    if (plan_.walls) views_.fluid.wall = back_end_.template allocate<Packed>("wall", n);
    if (plan_.solids) {
      bodies_ = back_end_.template mirror<BodyState>("bodies", scene_.bodies.size());
      views_.bodies = static_cast<std::uint32_t>(scene_.bodies.size());
      views_.body.body = bodies_.device;
    }
    if (plan_.wrench) {
      if (plan_.force_count > 0 && (plan_.neighbors || plan_.elastic))
        views_.body.force = back_end_.template allocate<Packed>("solid force", plan_.force_count);
      if (plan_.force_count > 0)
        views_.body.local = back_end_.template allocate<Packed>("solid local", plan_.force_count);
      views_.list.reactive = allocate_copy(back_end_, "reactive bodies", plan_.reactive);
      views_.list.reactive_count = static_cast<std::uint32_t>(plan_.reactive.size());
    }
    if (plan_.moving) {
      views_.list.rigid = allocate_copy(back_end_, "rigid bodies", plan_.rigid);
      views_.list.rigid_count = static_cast<std::uint32_t>(plan_.rigid.size());
    }
    if (plan_.elastic) allocate_elastic(back_end_, scene_, plan_, views_);
    if (plan_.fields || plan_.geometry || plan_.heat_walls) {
      const ContactStore store(scene_, plan_);
      const ContactFields fields = allocate_fields(back_end_, store);
      if (plan_.fields) contact_counts_ = allocate_contact(back_end_, store, fields, plan_, views_.contact);
      if (views_.contact.elastic_parts > 0)
        views_.elastic.pressed = back_end_.template allocate<Mat3>("elastic pressed", plan_.elastic_count);
      if (plan_.geometry) allocate_walls(back_end_, scene_, plan_, views_.grid, store, fields, views_.fluid);
      if (plan_.heat_walls) allocate_heat_walls(back_end_, scene_, store, fields, views_.heat);
    }
    if (plan_.elastic_rounds > 0) allocate_implicit(back_end_, scene_, plan_, views_);
    if (plan_.change) allocate_change(back_end_, scene_, plan_, views_);
    if (plan_.sleeps) allocate_sleep(back_end_, scene_, plan_, views_);
    if (n > 0)
      views_.health.part = back_end_.template allocate<HealthSums>("health parts", health_parts(views_.particles));
    health_ = back_end_.template mirror<HealthSums>("health", 1);
    views_.health.total = health_.device;
    input_ = back_end_.template mirror<StepBlock>("input", 1);
    views_.input.forcing = &input_.device->forcing;
    views_.input.proxy = input_.device->proxy;
    views_.heat.views.zones_on = &input_.device->heat_zones;
  }

  Scene scene_;
  Plan plan_;
  std::vector<std::string> warnings_;
  StepResults results_;
  B back_end_;
  StepViews views_;
  ContactCounts contact_counts_;
  typename B::template Mirror<StepBlock> input_;
  typename B::template Mirror<BodyState> bodies_;
  typename B::template Mirror<HealthSums> health_;
  typename B::template Mirror<float> frame_position_, frame_scalar_;
  typename B::template Mirror<std::uint8_t> frame_solid_;
  std::atomic<FrameState> frame_state_{FrameState::idle};
  bool frame_has_scalar_ = false;
  double frame_time_ = 0;
  std::uint64_t frame_step_ = 0;
  StepOutput output_;
};

}  // namespace palp
