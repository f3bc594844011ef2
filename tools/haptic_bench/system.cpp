#include "tools/haptic_bench/system.h"

#include <cmath>
#include <limits>

#include "sim_server/device_tracker.h"
#include "sim_server/messages_from_state.h"

namespace palp::bench {

namespace {

constexpr std::int64_t kStart = 1'000'000'000;  // of the bench's clock: stamps must be above zero
constexpr std::int64_t kPeriod = 1'000'000;     // of the bridge

std::int64_t to_ns(double seconds) { return std::llround(1e9 * seconds); }
double seconds_since_start(std::int64_t t_ns) { return 1e-9 * static_cast<double>(t_ns - kStart); }

RigidState moved(RigidState h, const Eigen::Vector3d& by) {
  h.position += by;
  return h;
}

RigidState handle_at_start(const Scene& scene) {
  const Body& tool = scene.bodies[scene.proxies[0].body];
  return at_rest(tool.position + tool.orientation * scene.proxies[0].handle, tool.orientation);
}

// The arm, with what goes wrong at it.
class BenchArm final : public HapticDevice {
 public:
  explicit BenchArm(const RunSetup& s, const RigidState& home)
      : faults_(s.faults), arm_(s.profile.setup<ArmModel>(), s.hand, home, moved(home, s.start)) {}
  const DeviceInfo& info() const noexcept override { return arm_.info(); }
  bool read(std::int64_t now_ns, DeviceReading& out) noexcept override {
    const bool good = arm_.read(now_ns, out);
    const double t = seconds_since_start(now_ns);
    if (faults_.hand_lets_go >= 0 && t >= faults_.hand_lets_go) out.dead_man = false;
    if (faults_.nan_readings >= 0 && t >= faults_.nan_readings)
      out.state.position.setConstant(std::numeric_limits<double>::quiet_NaN());
    return good;
  }
  bool write(const Wrench<double>& wrench) noexcept override { return arm_.write(wrench); }
  void show(LoopState state) noexcept override { arm_.show(state); }
  const RigidState& state() const { return arm_.true_state(); }

 private:
  Faults faults_;
  SimulatedDevice arm_;
};

// The server process: its mailbox, hand and simulation.
class BenchServer {
 public:
  explicit BenchServer(const RunSetup& s)
      : setup_(s), simulation_(make_simulation(at_rate(*s.scene, s.rate_hz), Backend::cpu)), step_(1 / s.rate_hz) {}

  // Its clock, which may jump away from the bench's and back.
  std::int64_t clock(std::int64_t t_ns) const {
    const LinkPair& link = setup_.link;
    if (link.clock_step_at <= 0) return t_ns;
    const std::int64_t periods = (t_ns - kStart) / to_ns(link.clock_step_at);
    return t_ns + (periods % 2 == 1 ? to_ns(link.clock_step) : 0);
  }

  void receive(const DeviceSample& sample, std::int64_t t_receive_ns) { tracker_.receive(sample, t_receive_ns); }

  ProxySample step(std::int64_t t_ns) {
    if (setup_.before_step) setup_.before_step(*simulation_, output().time);
    input_[0] = tracker_.input(clock(t_ns), step_, output().proxies[0].state);
    simulation_->step(input_);
    ProxySample s = make_proxy_sample(output().proxies[0], 0, tracker_.sample(), tracker_.engaged(),
                                      output().health.ok ? ServerState::running : ServerState::fault, output().time);
    s.header = {kProtocolVersion, kServerSession, 0, t_ns};
    return s;
  }
  const StepOutput& output() const { return simulation_->output(); }
  int sub_steps() const { return simulation_->sub_steps(); }

 private:
  static Scene at_rate(Scene scene, double rate_hz) {
    scene.config.rate_hz = rate_hz;
    return scene;
  }

  const RunSetup& setup_;
  std::unique_ptr<Simulation> simulation_;
  double step_;
  DeviceTracker tracker_;
  StepInput input_{};
};

LoopConfig config_of(const RunSetup& s) {
  LoopConfig c = s.profile.loop;
  c.own_session = kBridgeSession;
  if (s.variant != Variant::ours) c.blend_time = 0;
  if (s.variant != Variant::ours || !s.controller) {
    c.passivity.most_damping = c.angular_passivity.most_damping = 0;
    c.governor.budget = c.governor.angular_budget = 1e9;
  }
  return c;
}

class System {
 public:
  explicit System(const RunSetup& s)
      : setup_(s),
        home_(handle_at_start(*s.scene)),
        server_(s),
        arm_(s, home_),
        loop_(config_of(s), arm_),
        up_(s.link.up, 2 * s.seed),
        down_(s.link.down, 2 * s.seed + 1),
        step_ns_(to_ns(1 / s.rate_hz)) {
    // the two processes know nothing of each other's beat
    std::mt19937_64 random(s.seed);
    due_ns_ = next_step_ns_ = kStart + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(step_ns_));
    last_x_ = arm_.state();
  }

  Trace run() {
    const std::int64_t end = kStart + to_ns(setup_.seconds);
    std::int64_t next_tick = kStart;
    trace_.ticks.reserve(static_cast<std::size_t>((end - kStart) / kPeriod));
    while (next_tick < end && trace_.trouble.empty()) {
      if (next_step_ns_ < next_tick) {
        step(next_step_ns_);
      } else {
        tick(next_tick);
        if (setup_.stop && setup_.stop(trace_.ticks.back())) break;
        next_tick += kPeriod;
      }
    }
    trace_.report = loop_.report();
    trace_.sub_steps = server_.sub_steps();
    trace_.force_limit = loop_.config().limits.force;
    trace_.torque_limit = loop_.config().limits.torque;
    return std::move(trace_);
  }

 private:
  void step(std::int64_t t_ns) {
    const double t = seconds_since_start(t_ns);
    const Faults& f = setup_.faults;
    schedule_step(t_ns);
    if (f.server_dies >= 0 && t >= f.server_dies) return;
    std::uint64_t index = 0;
    std::int64_t t_receive = 0;
    if (up_.take(t_ns, index, t_receive)) server_.receive(sent_up_[index], server_.clock(t_receive));
    ProxySample s = server_.step(t_ns);
    if (!server_.output().health.ok) trace_.trouble = server_.output().health.cause;
    if (setup_.variant != Variant::ours) s.blend.fill(setup_.variant == Variant::held ? 0 : 1);
    if (f.nan_samples >= 0 && t >= f.nan_samples) s.wrench.force.fill(std::numeric_limits<double>::quiet_NaN());
    answer(s, t_ns + to_ns(setup_.compute));
  }

  // As links.cpp sends: until the next answer, the newest one again.
  void answer(ProxySample s, std::int64_t t_ns) {
    const std::int64_t next = next_step_ns_ + to_ns(setup_.compute);
    int times = 0;
    do {
      s.header.sequence = sent_down_.size() + 1;
      sent_down_.push_back(s);
      down_.send(t_ns, sent_down_.size() - 1);
      t_ns += kRepeatAfterNs;
    } while (t_ns < next && repeat(s, times++));
  }

  // As server.cpp paces itself: what comes late is made up for.
  void schedule_step(std::int64_t t_ns) {
    const Faults& f = setup_.faults;
    due_ns_ = std::max(due_ns_ + step_ns_, t_ns - 20 * step_ns_);
    next_step_ns_ = std::max({due_ns_, t_ns + to_ns(setup_.compute), t_ns + 1});
    const double t = seconds_since_start(next_step_ns_);
    if (f.server_stalls >= 0 && t >= f.server_stalls && t < f.server_stalls + f.stall_for)
      next_step_ns_ = kStart + to_ns(f.server_stalls + f.stall_for);
  }

  void tick(std::int64_t t_ns) {
    std::uint64_t index = 0;
    IncomingProxy in;
    const bool came = down_.take(t_ns, index, in.t_receive_ns);
    if (came) in.sample = sent_down_[index];
    loop_.tick(t_ns, 0, 0, came ? &in : nullptr);
    if (loop_.worth_sending()) {
      DeviceSample s = loop_.sample();
      s.header = {kProtocolVersion, kBridgeSession, sent_up_.size() + 1, t_ns};
      sent_up_.push_back(s);
      up_.send(t_ns, sent_up_.size() - 1);
    }
    note(t_ns);
    if (loop_.report().fault != LoopFault::none && setup_.faults.nan_readings < 0)
      trace_.trouble = palp::to_string(loop_.report().fault);
  }

  void note(std::int64_t t_ns) {
    const RigidState& now = arm_.state();
    const TickRecord& r = loop_.record();
    // the wrench of the last tick acted until this one
    port_[0] += last_sent_.force.dot(now.position - last_x_.position);
    port_[1] += last_sent_.torque.dot(rotation_between(last_x_.orientation, now.orientation));
    last_x_ = now;
    last_sent_ = r.sent;
    Tick k;
    k.t = seconds_since_start(t_ns);
    k.x = now.position - home_.position;
    k.turn = rotation_between(home_.orientation, now.orientation);
    k.v = now.linear;
    k.w = now.angular;
    k.force = r.sent.force;
    k.torque = r.sent.torque;
    k.port = port_;
    k.put_in = server_.output().proxies[0].energy;
    k.state = r.state;
    k.cut = r.cut;
    k.verdict = r.verdict;
    k.delay = 1e-9 * static_cast<double>(r.delay_ns);
    k.blend = r.blend_linear;
    k.share = loop_.sample().gains.stiffness / setup_.profile.loop.gains.stiffness;
    k.turn_share = loop_.sample().gains.angular_stiffness / setup_.profile.loop.gains.angular_stiffness;
    k.energy = r.energy_linear;
    k.damping = r.damping_linear;
    k.active = r.damping_linear > 0 || r.damping_angular > 0;
    trace_.ticks.push_back(k);
  }

  const RunSetup& setup_;
  RigidState home_;
  BenchServer server_;
  BenchArm arm_;
  HapticLoop loop_;
  Link up_, down_;
  std::vector<DeviceSample> sent_up_;
  std::vector<ProxySample> sent_down_;
  std::int64_t step_ns_, due_ns_ = 0, next_step_ns_ = 0;
  RigidState last_x_;
  Wrench<double> last_sent_ = zero_wrench();
  std::array<double, 2> port_{};
  Trace trace_;
};

}  // namespace

const char* to_string(Variant variant) {
  return variant == Variant::ours ? "ours" : variant == Variant::held ? "held wrench" : "local spring";
}

Trace run(const RunSetup& setup) { return System(setup).run(); }

}  // namespace palp::bench
