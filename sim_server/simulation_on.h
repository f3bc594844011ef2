// The simulation on one back end: owns the arrays that the plan names, carries states in and results out.
//
// Flow of a step: input block to the device -> sub-steps (step.h) -> body states and health back -> one wait.
#pragma once

#include <atomic>
#include <cmath>

#include "sim_server/contact_store.h"
#include "sim_server/elastic_store.h"
#include "sim_server/heat_plan.h"
#include "sim_server/pack_frame.h"
#include "sim_server/parameters.h"
#include "sim_server/particle_store.h"
#include "sim_server/simulation.h"
#include "sim_server/state_change_plan.h"
#include "sim_server/step.h"
#include "sim_server/step_results.h"

namespace palp {

template <class B>
class SimulationOn final : public Simulation {
 public:
  explicit SimulationOn(const Scene& scene)
      : scene_(scene),
        plan_(make_plan(scene, B::kSkinOverSpacing, B::kCellsPerReach)),
        results_(scene_, plan_),
        back_end_(scene.position.size()) {
    allocate();
    reset();
  }

  const Scene& scene() const override { return scene_; }
  std::string backend_name() const override { return back_end_.name(); }
  std::string numerics() const override { return describe(plan_, scene_); }

  double support_radius() const override { return plan_.support; }

  void set_parameter(const std::string& name, const std::string& value) override {
    SceneConfig config = scene_.config;
    apply_parameter(config, name, value);
    // pressure is the fluid's state, so the sound speed that gives it its meaning stays
    const NumericsConfig numerics = config.numerics;
    config.numerics.sound_speed = plan_.sound_speed;
    config.numerics.max_speed = plan_.max_speed;
    config.numerics.tension = plan_.tension;
    std::swap(scene_.config, config);
    try {
      plan_ = make_plan(scene_, B::kSkinOverSpacing, B::kCellsPerReach);
    } catch (...) {
      std::swap(scene_.config, config);
      throw;
    }
    scene_.config.numerics = numerics;
    views_.medium = make_medium(scene_, plan_);
    views_.cohesion = make_cohesion(scene_, plan_);
    if (plan_.viscous_stages > 0) allocate_viscosity();
    if (plan_.heat) views_.heat_medium = make_heat_medium(scene_, plan_);
    if (plan_.change) views_.change_medium = make_change_medium(scene_, plan_);
    back_end_.forget();
  }

  const StepOutput& step(const StepInput& input) override {
    results_.fill(input, output_.time, *input_.host);
    const bool heat = plan_.heat && (output_.step + 1) % static_cast<unsigned>(plan_.heat_interval) == 0;
    back_end_.execute(heat ? 1 : 0, plan_.heat ? 2 : 1, [this](int variant) {
      back_end_.push(input_);
      palp::step(back_end_, plan_, views_, variant == 1);
      if (plan_.wrench) back_end_.pull(bodies_);
      back_end_.pull(health_);
    });
    ++output_.step;
    output_.time = static_cast<double>(output_.step) / scene_.config.rate_hz;
    results_.read(bodies_.host, *health_.host, back_end_.crowded(), output_);
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
    if (plan_.heat) {
      back_end_.upload(s.enthalpy, store.enthalpy);
      back_end_.upload(const_cast<std::uint32_t*>(views_.heat.held), held_bodies(scene_));
      back_end_.upload(const_cast<HeatZone*>(views_.heat.zone), make_heat_zones(scene_));
    }
    if (plan_.wrench) {
      back_end_.upload(views_.body.local, store.local);
      back_end_.upload(const_cast<std::uint32_t*>(views_.reactive), plan_.reactive);
    }
    if (plan_.moving) back_end_.upload(const_cast<std::uint32_t*>(views_.rigid), plan_.rigid);
    if (plan_.elastic) reset_elastic();
    if (plan_.fields) reset_contact();
    if (plan_.change) reset_change();
    if (plan_.solids) back_end_.upload(views_.body.body, store.bodies);
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
      store.scatter_heat(start, views_.heat_medium, out);
    }
    if (plan_.elastic) snapshot_elastic(out);
    if (plan_.change) {
      std::vector<real> solid(store.id.size());
      back_end_.download(solid, s.solid);
      out.solid.resize(solid.size());
      for (std::size_t i = 0; i < solid.size(); ++i) out.solid[store.id[i]] = static_cast<float>(solid[i]);
    }
    out.time = output_.time;
  }

  bool begin_frame(FrameScalar scalar) override {
    if (frame_state_ != FrameState::idle) return false;
    if (frame_scalar_.device == nullptr && scalar != FrameScalar::none)
      frame_scalar_ = back_end_.template mirror<float>("frame scalar", views_.particles);
    if (frame_position_.device == nullptr)
      frame_position_ = back_end_.template mirror<float>("frame position", 3 * std::size_t(views_.particles));
    back_end_.for_each("frame", views_.particles,
                       PackFrame{views_.state, views_.medium, frame_position_.device, frame_scalar_.device, scalar});
    back_end_.begin_transfer(frame_position_, scalar == FrameScalar::none ? decltype(frame_scalar_){} : frame_scalar_);
    frame_has_scalar_ = scalar != FrameScalar::none;
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
    frame_state_ = FrameState::idle;
    return true;
  }

  Footprint footprint() const override { return {back_end_.arrays(), back_end_.launches()}; }

 private:
  enum class FrameState { idle, begun };

  ParticleView allocate_particles(const std::string& set) {
    const std::size_t n = scene_.position.size();
    ParticleView v;
    v.xV = back_end_.template allocate<Packed>(set + " position", n);
    v.vp = back_end_.template allocate<Packed>(set + " velocity", n);
    v.mass = back_end_.template allocate<real>(set + " mass", n);
    v.tag = back_end_.template allocate<Tag>(set + " tag", n);
    v.id = back_end_.template allocate<std::uint32_t>(set + " id", n);
    if (plan_.temperature) v.temperature = back_end_.template allocate<real>(set + " temperature", n);
    if (plan_.heat) v.enthalpy = back_end_.template allocate<real>(set + " enthalpy", n);
    if (plan_.change) v.solid = back_end_.template allocate<real>(set + " solid fraction", n);
    return v;
  }

  template <class T>
  T* allocate_copy(const std::string& name, const std::vector<T>& from) {
    if (from.empty()) return nullptr;
    T* to = back_end_.template allocate<T>(name, from.size());
    back_end_.upload(to, from);
    return to;
  }

  void allocate_elastic() {
    const ElasticStore store(scene_, plan_);
    const std::size_t n = plan_.elastic_count;
    ElasticViews& e = views_.elastic;
    e.count = plan_.elastic_count;
    e.rest = allocate_copy("elastic rest", store.rest);
    e.tag = allocate_copy("elastic tag", store.tag);
    e.first = allocate_copy("elastic first", store.first);
    e.neighbor = allocate_copy("elastic neighbors", store.neighbor);
    e.correction = allocate_copy("elastic correction", store.correction);
    e.projection = allocate_copy("elastic projection", store.projection);
    e.u = back_end_.template allocate<Packed>("elastic displacement", n);
    e.v = back_end_.template allocate<Packed>("elastic velocity", n);
    e.rotation = back_end_.template allocate<Quat>("elastic rotation", n);
    e.gradient = back_end_.template allocate<Mat3>("elastic gradient", n);
    e.stress = back_end_.template allocate<Mat3>("elastic stress", n);
    if (plan_.plastic) {
      e.plastic = back_end_.template allocate<Mat3>("elastic plastic part", n);
      e.hardened = back_end_.template allocate<real>("elastic plastic strain", n);
    }
    if (plan_.tears) {
      e.torn = back_end_.template allocate<std::uint8_t>("elastic torn bonds", store.neighbor.size());
      e.pull = back_end_.template allocate<Packed>("elastic pull", n);
      e.bearing = back_end_.template allocate<real>("elastic bearing", n);
    }
    views_.elastic_bodies = allocate_copy("elastic bodies", plan_.elastic_bodies);
  }

  void allocate_change() {
    const ChangeStore store(scene_, plan_);
    const std::size_t n = plan_.slots, all = n * kMaxBonds;
    ChangeViews& c = views_.change;
    c.count = plan_.slots;
    c.slot_of = allocate_copy("change slots", store.slot_of);
    c.group = allocate_copy("change groups", store.group);
    c.tag = allocate_copy("change tags", store.tag);
    views_.change_force_of = allocate_copy("change forces of", store.force_of);
    c.x = back_end_.template allocate<Packed>("change position", n);
    c.v = back_end_.template allocate<Packed>("change velocity", n);
    c.solid = back_end_.template allocate<real>("change solid fraction", n);
    c.before = back_end_.template allocate<real>("change solid fraction before", n);
    c.set = back_end_.template allocate<real>("change set", n);
    c.rotation = back_end_.template allocate<Quat>("bond rotation", n);
    c.gradient = back_end_.template allocate<Mat3>("bond gradient", n);
    c.stress = back_end_.template allocate<Mat3>("bond stress", n);
    c.correction = back_end_.template allocate<Mat3>("bond correction", n);
    c.projection = back_end_.template allocate<Mat3>("bond projection", n);
    c.soft = back_end_.template allocate<real>("bond softness", n);
    c.force = back_end_.template allocate<Packed>("bond force", n);
    c.bonds = back_end_.template allocate<std::uint32_t>("bond counts", n);
    c.bond = back_end_.template allocate<std::uint32_t>("bonds", all);
    c.own = back_end_.template allocate<Packed>("bond vectors", all);
    c.other = back_end_.template allocate<Packed>("bond vectors back", all);
    views_.change_medium = make_change_medium(scene_, plan_);
  }

  void reset_change() {
    const ChangeStore store(scene_, plan_);
    const ChangeViews& c = views_.change;
    back_end_.upload(c.x, store.x);
    back_end_.upload(c.v, store.v);
    back_end_.upload(c.solid, store.solid);
    back_end_.upload(c.before, store.solid);
    back_end_.upload(c.set, store.set);
    back_end_.upload(c.rotation, store.rotation);
    back_end_.upload(c.correction, store.correction);
    back_end_.upload(c.projection, store.projection);
    back_end_.upload(c.soft, store.soft);
    back_end_.upload(c.bonds, store.bonds);
    back_end_.upload(c.bond, store.bond);
    back_end_.upload(c.own, store.own);
    back_end_.upload(c.other, store.other);
    back_end_.upload(views_.state.solid, store.fraction);
  }

  void reset_elastic() {
    const ElasticStore store(scene_, plan_);
    back_end_.upload(views_.elastic.u, store.u);
    back_end_.upload(views_.elastic.v, store.v);
    back_end_.upload(views_.elastic.rotation, store.rotation);
    back_end_.upload(views_.elastic.gradient, std::vector<Mat3>(plan_.elastic_count, Mat3::Identity()));
    if (plan_.plastic) {
      back_end_.upload(views_.elastic.plastic, std::vector<Mat3>(plan_.elastic_count, Mat3::Identity()));
      back_end_.upload(views_.elastic.hardened, std::vector<real>(plan_.elastic_count, real(0)));
    }
    if (plan_.tears) {
      back_end_.upload(views_.elastic.correction, store.correction);
      back_end_.upload(views_.elastic.projection, store.projection);
      back_end_.upload(views_.elastic.torn, std::vector<std::uint8_t>(store.neighbor.size(), 0));
      back_end_.upload(views_.elastic.pull, std::vector<Packed>(plan_.elastic_count, Packed{0, 0, 0, 0}));
      back_end_.upload(views_.elastic.bearing, std::vector<real>(plan_.elastic_count, real(1)));
    }
  }

  void snapshot_elastic(Snapshot& out) {
    const std::size_t n = plan_.elastic_count;
    std::vector<Quat> rotation(n);
    std::vector<Mat3> gradient(n), plastic(plan_.plastic ? n : 0);
    std::vector<real> bearing(plan_.tears ? n : 0);
    back_end_.download(rotation, views_.elastic.rotation);
    back_end_.download(gradient, views_.elastic.gradient);
    if (plan_.plastic) back_end_.download(plastic, views_.elastic.plastic);
    if (plan_.tears) back_end_.download(bearing, views_.elastic.bearing);
    scatter_stored(scene_, plan_, views_.medium, {gradient, rotation, plastic, bearing}, out.stored);
  }

  void allocate_contact() {
    const ContactStore store(scene_, plan_);
    ContactViews& c = views_.contact;
    c.pairs = store.rigid_pairs;
    c.elastic_parts = static_cast<std::uint32_t>(store.elastic_part.size());
    c.few = store.few;
    contact_pairs_ = store.pair.size();
    c.pair = allocate_copy("contact pairs", store.pair);
    c.shape = allocate_copy("contact shapes", store.shape);
    c.piece = allocate_copy("contact pieces", store.piece);
    const Packed* node = allocate_copy("contact distances", store.node);
    c.grid = allocate_copy("contact grids", store.grids_at(node));
    c.point = allocate_copy("contact points", store.point);
    c.elastic_part = allocate_copy("contact elastic parts", store.elastic_part);
    c.by.of_body = allocate_copy("contact of bodies", store.of_body);
    c.by.part = allocate_copy("contact parts", store.part);
    c.state = back_end_.template allocate<ContactState>("contact states", store.states);
    c.by.wrench = back_end_.template allocate<PairWrench>("contact wrenches", contact_pairs_);
    contact_states_ = store.states;
  }

  void reset_contact() {
    back_end_.upload(views_.contact.state, std::vector<ContactState>(contact_states_, no_contact()));
    back_end_.upload(views_.contact.by.wrench, std::vector<PairWrench>(contact_pairs_, no_wrench()));
  }

  void allocate() {
    const std::size_t n = scene_.position.size();
    views_.particles = static_cast<std::uint32_t>(n);
    views_.state = allocate_particles("state");
    views_.grid = make_grid(scene_, plan_);
    if (plan_.meets) {
      const double reach = (plan_.support + plan_.skin) / scene_.spacing;
      views_.sorted = allocate_particles("sorted");
      views_.grid.start =
          back_end_.allocate_sort(views_.particles, views_.grid.cells(), 4.0 / 3.0 * EIGEN_PI * reach * reach * reach);
    }
    views_.medium = make_medium(scene_, plan_);
    views_.cohesion = make_cohesion(scene_, plan_);
    if (plan_.heat) allocate_heat();
    if (plan_.viscous_stages > 0) allocate_viscosity();
    if (plan_.fluid) views_.acceleration = back_end_.template allocate<Packed>("acceleration", n);
    if (plan_.fluid && plan_.solids && plan_.method == Method::accurate)
      views_.wall = back_end_.template allocate<Packed>("wall", n);
    if (plan_.solids) {
      bodies_ = back_end_.template mirror<BodyState>("bodies", scene_.bodies.size());
      views_.bodies = static_cast<std::uint32_t>(scene_.bodies.size());
      views_.body.body = bodies_.device;
    }
    if (plan_.wrench) {
      if (plan_.meets || plan_.elastic)
        views_.body.force = back_end_.template allocate<Packed>("solid force", plan_.force_count);
      views_.body.local = back_end_.template allocate<Packed>("solid local", plan_.force_count);
      views_.reactive = back_end_.template allocate<std::uint32_t>("reactive bodies", plan_.reactive.size());
      views_.reactive_count = static_cast<std::uint32_t>(plan_.reactive.size());
    }
    if (plan_.moving) {
      views_.rigid = back_end_.template allocate<std::uint32_t>("rigid bodies", plan_.rigid.size());
      views_.rigid_count = static_cast<std::uint32_t>(plan_.rigid.size());
    }
    if (plan_.elastic) allocate_elastic();
    if (plan_.fields) allocate_contact();
    if (plan_.change) allocate_change();
    views_.health_part = back_end_.template allocate<HealthSums>("health parts", kHealthBlocks);
    health_ = back_end_.template mirror<HealthSums>("health", 1);
    views_.health = health_.device;
    input_ = back_end_.template mirror<StepBlock>("input", 1);
    views_.forcing = &input_.device->forcing;
    views_.proxy = input_.device->proxy;
    views_.heat.zones_on = &input_.device->heat_zones;
  }

  // A parameter that is set later may be the first to ask for it.
  void allocate_viscosity() {
    ViscosityViews& v = views_.viscosity;
    if (v.stage[0] != nullptr) return;
    for (Packed*& stage : v.stage)
      stage = back_end_.template allocate<Packed>("viscous velocity", scene_.position.size());
    if (!plan_.moving) return;
    v.solid = back_end_.template allocate<Packed>("viscous solid force", plan_.force_count);
    v.body = back_end_.template allocate<ViscousBody>("viscous bodies", scene_.bodies.size());
  }

  void allocate_heat() {
    views_.heat_medium = make_heat_medium(scene_, plan_);
    views_.heat.held = back_end_.template allocate<std::uint32_t>("heat held bodies", scene_.bodies.size());
    const std::size_t zones = scene_.config.heat_zones.size();
    if (zones == 0) return;
    views_.heat.zones = static_cast<std::uint32_t>(zones);
    views_.heat.zone = back_end_.template allocate<HeatZone>("heat zones", zones);
    views_.heat.zone_volume = back_end_.template allocate<real>("heat zone volumes", zones);
  }

  Scene scene_;
  Plan plan_;
  StepResults results_;
  B back_end_;
  StepViews views_;
  std::size_t contact_states_ = 0, contact_pairs_ = 0;
  typename B::template Mirror<StepBlock> input_;
  typename B::template Mirror<BodyState> bodies_;
  typename B::template Mirror<HealthSums> health_;
  typename B::template Mirror<float> frame_position_, frame_scalar_;
  std::atomic<FrameState> frame_state_{FrameState::idle};
  bool frame_has_scalar_ = false;
  double frame_time_ = 0;
  std::uint64_t frame_step_ = 0;
  StepOutput output_;
};

}  // namespace palp
