#include "sim_server/server.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "config/error.h"
#include "config/parameter_ranges.h"
#include "idl/clock.h"
#include "idl/validate.h"
#include "sim_server/bus_links.h"
#include "sim_server/device_tracker.h"
#include "sim_server/explain.h"
#include "sim_server/gpu_turns.h"
#include "sim_server/messages_from_state.h"
#include "sim_server/solver/bill.h"
#include "sim_server/solver/changeable_parameters.h"
#include "sim_server/status_reporter.h"
#include "sim_server/trade/choice.h"

namespace palp {
namespace {

using State = ServerState;

constexpr int kCommandsAStep = 16;  // so that no flood of them keeps the simulation, or the end, waiting
constexpr int kMostSingleSteps = 1000;

// Real-time factor over the last second or so of running.
class Pace {
 public:
  explicit Pace(std::int64_t period_ns) : period_ns_(period_ns), next_ns_(now_ns() + period_ns) {}
  void restart() {
    next_ns_ = now_ns() + period_ns_;
    window_ns_ = now_ns();
    window_steps_ = 0;
  }
  // When the next step is due.
  std::int64_t next_ns() const { return next_ns_; }
  // Sleeps until the next step is due. A step that came late is made up for within a few periods; beyond that time is
  // let go: slow motion, not a burst.
  void wait(bool paced, GpuTurns& gpu) {
    const std::int64_t now = now_ns();
    if (paced && now < next_ns_) {
      if (gpu.viewer_draws(now)) {
        sleep_until(next_ns_ - kTurnToServer);
        gpu.take_back();
      }
      sleep_until(next_ns_);
    }
    next_ns_ = std::max(next_ns_ + period_ns_, now - kMakeUp * period_ns_);
    ++window_steps_;
    if (now - window_ns_ > 500'000'000) {
      factor_ = static_cast<double>(window_steps_ * period_ns_) / static_cast<double>(now - window_ns_);
      window_ns_ = now;
      window_steps_ = 0;
    }
  }
  double factor() const { return factor_; }

 private:
  static constexpr std::int64_t kMakeUp = 20;
  std::int64_t period_ns_, next_ns_, window_ns_ = now_ns(), window_steps_ = 0;
  double factor_ = 1;
};

StepShare share_of(const Histogram& steps) {
  return {steps.count(), steps.quantile_us(0.5), steps.quantile_us(0.99), steps.max_us()};
}

Json json_of(const StepShare& s) {
  return {{"steps", s.steps}, {"step_p50_us", s.p50_us}, {"step_p99_us", s.p99_us}, {"step_max_us", s.max_us}};
}

Effort effort_of(const Simulation& simulation, const ServerOptions& options) {
  const Scene& scene = simulation.scene();
  return {scene.position.size(), scene.config.accuracy, !options.as_fast_as_possible, 1e6 / scene.config.rate_hz};
}

class Server {
 public:
  Server(Simulation& simulation, Bus& bus, const ServerOptions& options, const SceneChoice& scenes)
      : simulation_(simulation),
        options_(options),
        scenes_(scenes),
        output_(&simulation.output()),
        step_(1.0 / simulation.scene().config.rate_hz),
        haptic_(bus, simulation.scene()),
        frames_(bus, simulation),
        control_(bus),
        scene_writer_(bus.writer<SceneDescription>()),
        status_(bus, gauges_, effort_of(simulation, options), haptic_, frames_, control_) {
    SceneDescription scene = describe_scene(simulation_);
    if (!scene_writer_->publish(scene))
      throw std::runtime_error("the bus refused the scene's description: its meshes are too large for one message");
    for (const std::string& warning : simulation.warnings()) control_.event(Severity::warning, 0, warning);
    if (options.start_paused) gauges_.state = State::paused;
    bill();
  }

  Served run(const std::atomic<int>& stop) {
    prctl(PR_SET_TIMERSLACK, 1000);
    // ahead of pictures and recordings where that is allowed, behind the bridge's real-time loop
    setpriority(PRIO_PROCESS, 0, -10);
    const std::int64_t begin = now_ns();
    Pace pace(static_cast<std::int64_t>(std::llround(1e9 * step_)));
    Command command;
    while (!stop && !quit_ && !next_ &&
           (options_.seconds <= 0 || 1e-9 * static_cast<double>(now_ns() - begin) < options_.seconds)) {
      for (int k = 0; k < kCommandsAStep && !quit_ && !next_ && control_.take(command); ++k) obey(command);
      const std::int64_t t0 = now_ns();
      if (gauges_.state == State::running || single_steps_ > 0)
        advance(t0, options_.as_fast_as_possible ? t0 : pace.next_ns());
      else
        publish();
      pace.wait(!options_.as_fast_as_possible, gpu_);
      gauges_.real_time_factor = pace.factor();
      if (gauges_.state == State::running) wall_ns_ += now_ns() - t0;
    }
    return {summary(), std::move(next_), gauges_.state == State::paused};
  }

 private:
  // next_ns: when the step after this one is due.
  void advance(std::int64_t t0, std::int64_t next_ns) {
    for (std::size_t p = 0; p < simulation_.scene().proxies.size(); ++p) {
      TimedDeviceSample sample;
      if (haptic_.take(p, sample)) trackers_[p].receive(sample.sample, sample.t_receive_ns);
      input_[p] = trackers_[p].input(t0, step_, output_->proxies[p].state);
    }
    const std::int64_t t1 = now_ns();
    gpu_.begin_step(t1);
    output_ = &simulation_.step(input_);
    const std::int64_t t2 = now_ns();
    if (single_steps_ > 0) --single_steps_;
    gauges_.step_time.add(t2 - t1);
    (gpu_.viewer_draws(t2) ? beside_viewers_ : without_viewers_).add(t2 - t1);
    if (t2 - t1 > static_cast<std::int64_t>(1e9 * step_)) ++gauges_.slow_steps;
    ++gauges_.steps;
    judge();
    publish();
    const bool packs = frames_.offer(*output_, t2);
    // a frame is packed in the time that is left: between the pieces of a picture it would take so long that the next
    // step waits
    const std::int64_t t3 = now_ns();
    gpu_.end_step(t3, packs ? t3 : next_ns);
    gauges_.handover.add((t1 - t0) + (now_ns() - t2));
  }

  void show() {
    const Health& h = output_->health;
    gauges_.sim_time = output_->time;
    gauges_.max_speed = h.max_speed;
    gauges_.max_compression = h.max_compression;
    gauges_.kinetic_energy = h.kinetic_energy;
    gauges_.expected_speed = h.expected_speed;
    gauges_.mean_compression = h.mean_compression;
    gauges_.expected_compression = h.expected_compression;
    gauges_.doubtful = !h.doubt.empty();
    gauges_.outside = h.outside;
    gauges_.gone_mass = h.inactive_mass;
  }

  // Once a run, when the first fluid is let go.
  void tell_of_loss() {
    if (output_->health.inactive == 0 || told_of_loss_) return;
    told_of_loss_ = true;
    control_.event(Severity::warning, output_->time,
                   "fluid has left the domain and is let go: it takes no part any more; a reset brings it back");
  }

  // Once a run for each of the two.
  void tell_of_doubt(bool& told, const std::string& sentence) {
    if (sentence.empty() || std::exchange(told, true)) return;
    spdlog::warn("{}", sentence);
    control_.event(Severity::warning, output_->time, sentence);
  }

  // Single steps that were still to be taken are void.
  void enter(State state) {
    gauges_.state = state;
    single_steps_ = 0;
  }

  void judge() {
    show();
    tell_of_loss();
    tell_of_doubt(told_of_doubt_, output_->health.doubt);
    tell_of_doubt(told_of_notice_, output_->health.notice);
    Health h = output_->health;
    if (!h.ok) h.cause = fmt::format("at {:.3f} s: {}", output_->time, h.cause);
    record_.add(h);
    if (h.ok) return;
    enter(State::fault);
    if (cause_.empty()) cause_ = h.cause;
    spdlog::error("the simulation stopped {}", cause_);
    control_.event(Severity::fault, output_->time, "the simulation stopped " + cause_ + "; reset or quit");
  }

  void publish() {
    const State state = gauges_.state;
    for (std::size_t p = 0; p < simulation_.scene().proxies.size(); ++p) {
      haptic_.put(p, make_proxy_sample(output_->proxies[p], simulation_.scene().proxies[p].device,
                                       trackers_[p].sample(), trackers_[p].engaged(), state, output_->time));
    }
    haptic_.flush();
  }

  void obey(const Command& c) {
    try {
      control_.reply(c, true, carry_out(c));
    } catch (const std::exception& error) {
      control_.reply(c, false, error.what());
    }
  }

  std::string carry_out(const Command& c) {
    switch (c.kind) {
      case CommandKind::pause:
        if (gauges_.state == State::fault)
          throw ConfigError("the simulation has stopped " + cause_ + "; reset or quit");
        enter(State::paused);
        return "paused";
      case CommandKind::resume:
        if (gauges_.state == State::fault)
          throw ConfigError("the simulation has stopped " + cause_ + "; reset or quit");
        enter(State::running);
        return "running";
      case CommandKind::step:
        if (gauges_.state != State::paused) throw ConfigError("single steps are taken while paused; pause first");
        if (single_steps_ >= kMostSingleSteps)
          throw ConfigError(fmt::format("{} single steps are still to be taken; wait for them", single_steps_));
        ++single_steps_;
        return "one step";
      case CommandKind::reset:
        simulation_.reset();
        told_of_loss_ = told_of_doubt_ = told_of_notice_ = false;
        trackers_ = {};
        show();
        enter(gauges_.state == State::fault ? State::running : gauges_.state.load());
        return "reset";
      case CommandKind::quit:
        quit_ = true;
        return "quitting";
      case CommandKind::set_parameter:
        return set_parameter(c.name, c.value);
      case CommandKind::get_parameter:
        if (c.name == kScenesName) return fmt::format("{}", fmt::join(scenes_.names, "\n"));
        return c.name == kBillName ? bill() : list_parameters(c.name);
      case CommandKind::load_scene:
        return load_scene(c.name);
    }
    throw ConfigError("unknown command");
  }

  // Opens the scene that this run ends for. Only names that were told of are opened: a path from the bus is no scene.
  std::string load_scene(const std::string& name) {
    if (!name.empty() && std::ranges::find(scenes_.names, name) == scenes_.names.end())
      throw ConfigError(
          fmt::format("there is no scene '{}'; expected one of {}", name, fmt::join(scenes_.names, ", ")));
    const State before = gauges_.state;
    if (before == State::running) gauges_.state = State::paused;
    publish();  // the hand is let go before the simulation falls silent
    try {
      next_ = scenes_.open(name);
    } catch (...) {
      gauges_.state = before;
      throw;
    }
    gauges_.state = before;
    return fmt::format("'{}' follows", next_->scene().config.name);
  }

  std::string set_parameter(const std::string& name, const std::string& value) {
    if (name == "stream.scalar") {
      const std::optional<ScalarField> field = scalar_field_from(value);
      if (!field) throw ConfigError("stream.scalar is '" + value + "'; expected " + names_of_scalar_fields());
      frames_.set_scalar(*field);
    } else if (name == "stream.particle_rate_hz") {
      frames_.set_rate(parse_parameter(parameter_row(name), name, value).at(0));
    } else {
      simulation_.set_parameter(name, value);
      bill_.clear();
      return name + " is " + value + "; " + simulation_.numerics();
    }
    return name + " is " + value;
  }

  // Returns the bill of the plan as it is now (solver/bill.h), for people: as many of its lines as a message holds.
  const std::string& bill() {
    if (bill_.empty()) bill_ = text_of(planned_bill(simulation_));
    if (bill_.size() > kMaxText) bill_.resize(bill_.rfind('\n', kMaxText - 1) + 1);
    return bill_;
  }

  // Returns a line for each parameter, or for the one of that name.
  std::string list_parameters(const std::string& name) const {
    std::vector<Parameter> all = parameters_of(simulation_.scene().config);
    const Range& rates = parameter_row("stream.particle_rate_hz").range;
    Parameter rate{"stream.particle_rate_hz", fmt::format("{:g}", frames_.rate()), rates.unit, rates.min, rates.max};
    all.push_back(rate);
    std::string text;
    for (const Parameter& p : all)
      if (name.empty() || p.name == name)
        text += fmt::format("{}\t{}\t{}\t{:g}\t{:g}\n", p.name, p.value, p.unit, p.low, p.high);
    if (name.empty() || name == "stream.scalar")
      text += fmt::format("stream.scalar\t{}\t\t\t\n", row_of(frames_.scalar()).name);
    if (text.empty()) throw ConfigError("there is no parameter '" + name + "'; expected one of those that get lists");
    text.pop_back();
    return text;
  }

  ServerSummary summary() const {
    ServerSummary s;
    s.steps = gauges_.steps;
    s.sim_time = step_ * static_cast<double>(gauges_.steps);
    s.wall_time = 1e-9 * static_cast<double>(wall_ns_);
    s.step_p50_us = gauges_.step_time.quantile_us(0.5);
    s.step_p99_us = gauges_.step_time.quantile_us(0.99);
    s.step_max_us = gauges_.step_time.max_us();
    s.beside_viewers = share_of(beside_viewers_);
    s.without_viewers = share_of(without_viewers_);
    s.handover_p50_us = gauges_.handover.quantile_us(0.5);
    s.handover_p99_us = gauges_.handover.quantile_us(0.99);
    s.slow_steps = gauges_.slow_steps;
    s.frames = frames_.sent();
    s.shared_frames = frames_.shared();
    s.dropped_samples = haptic_.dropped() + control_.dropped();
    s.record = record_;
    return s;
  }

  Simulation& simulation_;
  const ServerOptions options_;
  const SceneChoice& scenes_;
  const StepOutput* output_;
  const double step_;  // [s]
  std::string bill_;   // empty: a parameter has changed since
  Gauges gauges_;
  HapticLink haptic_;
  FrameLink frames_;
  ControlLink control_;
  std::unique_ptr<Writer<SceneDescription>> scene_writer_;
  std::array<DeviceTracker, kMaxProxies> trackers_;
  GpuTurns gpu_{simulation_};
  Histogram beside_viewers_, without_viewers_;  // time of steps while a viewer draws on the same GPU, and of the others
  StepInput input_{};
  int single_steps_ = 0;
  bool quit_ = false;
  std::unique_ptr<Simulation> next_;
  bool told_of_loss_ = false, told_of_doubt_ = false, told_of_notice_ = false;
  std::int64_t wall_ns_ = 0;
  std::string cause_;            // of the first fault
  HealthRecord record_;          // of all steps, across resets
  ServerStatusReporter status_;  // last: reads what the others hold
};

}  // namespace

Served serve(Simulation& simulation, Bus& bus, const ServerOptions& options, const SceneChoice& scenes,
             const std::atomic<int>& stop) {
  return Server(simulation, bus, options, scenes).run(stop);
}

Json json_of(const ServerSummary& s, const Simulation& simulation) {
  Json out{{"scene", simulation.scene().config.name},
           {"backend", simulation.backend_name()},
           {"numerics", simulation.numerics()},
           {"chosen", json_of(simulation.scene().config.choice)},
           {"particles", simulation.scene().position.size()},
           {"steps", s.steps},
           {"sim_time_s", s.sim_time},
           {"real_time_factor", s.real_time_factor()},
           {"step_p50_us", s.step_p50_us},
           {"step_p99_us", s.step_p99_us},
           {"step_max_us", s.step_max_us},
           {"slow_steps", s.slow_steps},
           {"beside_viewers", json_of(s.beside_viewers)},
           {"without_viewers", json_of(s.without_viewers)},
           {"handover_p50_us", s.handover_p50_us},
           {"handover_p99_us", s.handover_p99_us},
           {"frames", s.frames},
           {"shared_frames", s.shared_frames},
           {"dropped_samples", s.dropped_samples},
           {"warnings", simulation.warnings()},
           {"healthy", s.record.healthy()},
           {"cause", s.record.trouble()}};
  out.update(json_of(s.record));
  return out;
}

}  // namespace palp
