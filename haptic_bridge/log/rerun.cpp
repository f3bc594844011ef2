#include "haptic_bridge/log/rerun.h"

#include <bit>
#include <concepts>
#include <filesystem>
#include <limits>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "config/error.h"
#include "config/text_file.h"
#include "haptic_bridge/log/output_file.h"

namespace palp {

namespace {

constexpr std::uint64_t kMagic = 0x0031'4b43'4954'4c50;  // "PLTICK1"
constexpr std::uint64_t kMostTicks = 100'000'000;
constexpr std::size_t kMostBytes = std::size_t{1} << 36;
constexpr std::size_t kWord = 8;                           // bytes
constexpr std::int64_t kLatestNs = std::int64_t{1} << 60;  // 36 years; few such times add up without overflow

// Each value as eight bytes. The same list of fields (fields(), below) writes and reads.
class Writer {
 public:
  explicit Writer(fmt::memory_buffer& out) : out_(out) {}
  template <class T>
  void operator()(const T& value) {
    if constexpr (std::is_same_v<T, double>) {
      word(std::bit_cast<std::uint64_t>(value));
    } else {
      word(static_cast<std::uint64_t>(value));
    }
  }

 private:
  void word(std::uint64_t w) {
    char bytes[kWord];
    for (std::size_t i = 0; i < kWord; ++i) bytes[i] = static_cast<char>(w >> (8 * i));
    out_.append(bytes, bytes + kWord);
  }
  fmt::memory_buffer& out_;
};

class Reader {
 public:
  Reader(const std::string& bytes, const std::string& path) : bytes_(bytes), path_(path) {}
  template <class T>
  void operator()(T& value) {
    const std::uint64_t w = word();
    if constexpr (std::is_same_v<T, double>) {
      value = std::bit_cast<double>(w);
    } else if constexpr (std::is_same_v<T, bool>) {
      if (w > 1) fail("a value that is neither true nor false");
      value = w == 1;
    } else {
      value = static_cast<T>(w);
      if (static_cast<std::uint64_t>(value) != w) fail("a number that is out of range");
    }
  }
  bool at_end() const { return at_ == bytes_.size(); }
  std::size_t words_left() const { return (bytes_.size() - at_) / kWord; }
  [[noreturn]] void fail(const std::string& what) const {
    throw ConfigError(
        fmt::format("{}: at byte {}: {}; the file is not one that this palp-haptic-bridge wrote", path_, at_, what));
  }

 private:
  std::uint64_t word() {
    if (bytes_.size() - at_ < kWord) fail("it ends in the middle");
    std::uint64_t w = 0;
    for (std::size_t i = 0; i < kWord; ++i)
      w |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes_[at_ + i])) << (8 * i);
    at_ += kWord;
    return w;
  }
  const std::string& bytes_;
  const std::string& path_;
  std::size_t at_ = 0;
};

template <class T, class U>
concept Of = std::same_as<std::remove_const_t<T>, U>;

// ---- the fields of what is kept; T is const where they are written

// A field that is not in these lists is not kept, and the run that it changes is not the same.
static_assert(sizeof(LoopConfig) == 464 && sizeof(ProxySample) == 392 && sizeof(DeviceReading) == 128,
              "a field is new: add it to its list below, and count on");

template <class A, Of<Eigen::Vector3d> T>
void fields(A& a, T& v) {
  for (int i = 0; i < 3; ++i) a(v[i]);
}
template <class A, Of<Eigen::Quaterniond> T>
void fields(A& a, T& q) {
  for (int i = 0; i < 4; ++i) a(q.coeffs()[i]);
}
template <class A, Of<RigidState> T>
void fields(A& a, T& h) {
  fields(a, h.position), fields(a, h.orientation), fields(a, h.linear), fields(a, h.angular);
}
template <class A, Of<Wrench<double>> T>
void fields(A& a, T& w) {
  fields(a, w.force), fields(a, w.torque);
}
template <class A, class T>
void numbers(A& a, T& values) {
  for (auto& value : values) a(value);
}
template <class A, Of<CouplingGains> T>
void fields(A& a, T& g) {
  a(g.stiffness), a(g.damping), a(g.angular_stiffness), a(g.angular_damping);
}
template <class A, Of<PassivityConfig> T>
void fields(A& a, T& p) {
  a(p.start), a(p.most), a(p.device_damping), a(p.slowest), a(p.most_damping), a(p.settling_time);
}
template <class A, Of<WrenchLimits> T>
void fields(A& a, T& l) {
  a(l.force), a(l.torque), a(l.force_slew), a(l.torque_slew);
  fields(a, l.axis_force), fields(a, l.axis_torque);
  a(l.continuous_force), a(l.continuous_torque), a(l.power);
}
template <class A, Of<LoopConfig> T>
void fields(A& a, T& c) {
  a(c.period_ns), a(c.device), a(c.own_session);
  fields(a, c.gains), fields(a, c.limits);
  a(c.safety.overrun_ns), a(c.safety.late_ticks), a(c.safety.bad_samples), a(c.safety.tool_speed),
      a(c.safety.tool_turn);
  fields(a, c.passivity), fields(a, c.angular_passivity);
  a(c.governor.budget), a(c.governor.angular_budget), a(c.governor.memory), a(c.governor.slowest_rise);
  a(c.workspace.motion_scale), a(c.workspace.force_scale), a(c.workspace.relative);
  a(c.stale.fade_start_ns), a(c.stale.fade_end_ns), a(c.stale.zero_at_ns);
  a(c.round_trip_allowance_ns), a(c.blend_time), a(c.fresh_ns), a(c.ramp_up), a(c.ramp_down), a(c.ramp_after_clutch);
  a(c.slew_recovery), a(c.fade_damping), a(c.fade_angular_damping), a(c.max_speed), a(c.max_angular_speed),
      a(c.max_bad_ticks);
}
template <class A, Of<ProxySample> T>
void fields(A& a, T& s) {
  a(s.header.version), a(s.header.session), a(s.header.sequence), a(s.header.t_send_ns);
  a(s.device), a(s.flags), a(s.sim_time), a(s.device_session), a(s.device_sequence), a(s.t_device_ns);
  numbers(a, s.device_pose.position), numbers(a, s.device_pose.orientation);
  numbers(a, s.device_twist.linear), numbers(a, s.device_twist.angular);
  numbers(a, s.proxy_pose.position), numbers(a, s.proxy_pose.orientation);
  numbers(a, s.proxy_twist.linear), numbers(a, s.proxy_twist.angular);
  numbers(a, s.wrench.force), numbers(a, s.wrench.torque);
  fields(a, s.gains);
  numbers(a, s.blend), numbers(a, s.energy);
}
template <class A, Of<DeviceReading> T>
void fields(A& a, T& r) {
  fields(a, r.state);
  a(r.dead_man), a(r.powered), a(r.chain_closed), a(r.shifted), a(r.strained), a(r.alarms), a(r.buttons);
}
template <class A, Of<TickInput> T>
void fields(A& a, T& i) {
  a(i.now_ns), a(i.lateness_ns), a(i.missed), a(i.told), a(i.refused), a(i.came);
  if (i.came) fields(a, i.incoming.sample), a(i.incoming.t_receive_ns);
  a(i.was_read), fields(a, i.reading), a(i.was_written);
}
template <class A, Of<TickResult> T>
void fields(A& a, T& r) {
  fields(a, r.sent), a(r.state), a(r.gains_share);
}

// ---- running again

// Gives the loop the readings that were kept.
class KeptDevice final : public HapticDevice {
 public:
  const DeviceInfo& info() const noexcept override { return info_; }
  bool read(std::int64_t, DeviceReading& out) noexcept override {
    out = input->reading;
    return input->was_read;
  }
  bool write(const Wrench<double>&) noexcept override { return input->was_written; }
  const TickInput* input = nullptr;

 private:
  // the limits of the real one are in the configuration that was kept
  DeviceInfo info_{"kept run", std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), true};
};

TickResult result_of(const TickRecord& r) { return {r.sent, r.state, r.gains_share}; }

bool same(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }
bool same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return same(a.x(), b.x()) && same(a.y(), b.y()) && same(a.z(), b.z());
}
bool same(const TickResult& a, const TickResult& b) {
  return same(a.sent.force, b.sent.force) && same(a.sent.torque, b.sent.torque) && a.state == b.state &&
         same(a.gains_share, b.gains_share);
}

std::string text_of(const TickResult& r) {
  const auto vector = [](const Eigen::Vector3d& v) { return fmt::format("{} {} {}", v.x(), v.y(), v.z()); };
  return fmt::format("{}, force {}, torque {}, {} of the gains", to_string(r.state), vector(r.sent.force),
                     vector(r.sent.torque), r.gains_share);
}

// Checks a time that the loop computes with. A sample's own stamps are not checked: they came from the bus, and the
// loop's gate judges them.
bool is_time(std::int64_t ns) { return -kLatestNs <= ns && ns <= kLatestNs; }
bool has_times(const TickInput& i) {
  return is_time(i.now_ns) && is_time(i.lateness_ns) && (!i.came || is_time(i.incoming.t_receive_ns));
}

// Checks that each number of a configuration is one that a profile could have given: none is negative.
struct Plausible {
  template <class T>
  void operator()(const T& value) {
    if constexpr (std::is_same_v<T, double>) {
      holds = holds && value >= 0;
    } else if constexpr (std::is_same_v<T, std::int64_t>) {
      holds = holds && value >= 0 && is_time(value);
    }
  }
  bool holds = true;
};

// A run of so many ticks is no longer than this.
std::size_t kept_bytes(std::size_t ticks) {
  fmt::memory_buffer head, tick;
  Writer write_head(head), write_tick(tick);
  const LoopConfig config;
  TickInput most;
  most.came = true;
  const TickResult result;
  fields(write_head, config);
  fields(write_tick, most);
  fields(write_tick, result);
  return 3 * sizeof(std::uint64_t) + head.size() + ticks * tick.size();
}

}  // namespace

void write_ticks(const FlightLog& log, const LoopConfig& config, const std::string& path) {
  write_whole_file("kept run", path, [&](OutputFile& file) {
    const std::size_t ticks = log.size();
    fmt::memory_buffer out;
    Writer write(out);
    write(kMagic);
    write(static_cast<std::uint64_t>(ticks));
    write(ticks > 0 ? log.at(0).tick : 1);
    fields(write, config);
    for (std::size_t i = 0; i < ticks; ++i) {
      fields(write, log.input_at(i));
      const TickResult result = result_of(log.at(i));
      fields(write, result);
      if (out.size() > 1 << 16) {
        file.write(out);
        out.clear();
      }
    }
    file.write(out);
  });
}

std::string ticks_beside(const std::string& flight_log) {
  return std::filesystem::path(flight_log).replace_extension(".ticks").string();
}

void write_log_and_run(const FlightLog& log, const LoopConfig& config, const std::string& flight_log) {
  log.write_csv(flight_log);
  write_ticks(log, config, ticks_beside(flight_log));
  log.set_written();
}

LogRoom::LogRoom(const std::string& flight_log, std::size_t ticks)
    : csv("flight log", flight_log, most_csv_bytes(ticks)),
      run("kept run", ticks_beside(flight_log), kept_bytes(ticks)) {}

KeptRun read_ticks(const std::string& path) {
  const std::string bytes = read_text_file(path, kMostBytes);
  Reader read(bytes, path);
  std::uint64_t magic = 0, ticks = 0;
  read(magic);
  if (magic != kMagic) read.fail("it does not begin as a kept run does");
  read(ticks);
  // a tick is more than 30 words; a length that lies must not cost memory
  if (ticks > kMostTicks || ticks > read.words_left() / 30) read.fail("it is shorter than its number of ticks says");
  KeptRun run;
  read(run.first_tick);
  fields(read, run.config);
  Plausible plausible;
  fields(plausible, std::as_const(run.config));
  if (!plausible.holds) read.fail("a configuration that cannot be");
  run.inputs.resize(ticks);
  run.results.resize(ticks);
  for (std::size_t i = 0; i < ticks; ++i) {
    fields(read, run.inputs[i]);
    fields(read, run.results[i]);
    if (!has_times(run.inputs[i])) read.fail("a time that cannot be");
    if (run.inputs[i].told > LoopFault::unguarded) read.fail("a fault that there is not");
    if (run.results[i].state > LoopState::fault) read.fail("a state that there is not");
  }
  if (!read.at_end()) read.fail("there is more than its number of ticks says");
  return run;
}

Rerun run_again(const KeptRun& run) {
  if (run.first_tick != 1)
    throw ConfigError(
        fmt::format("the kept run begins at tick {}, and only one from the first tick on can be run "
                    "again: keep more of it, with --log-seconds",
                    run.first_tick));
  KeptDevice device;
  HapticLoop loop(run.config, device);
  Rerun rerun;
  for (const TickInput& input : run.inputs) {
    device.input = &input;
    if (input.told != LoopFault::none) loop.fail(input.told);
    loop.note_refused(input.refused);
    loop.tick(input.now_ns, input.lateness_ns, input.missed, input.came ? &input.incoming : nullptr);
    const TickResult now = result_of(loop.record());
    const TickResult& then = run.results[rerun.ticks++];
    if (same(now, then)) continue;
    rerun.differs_at = rerun.ticks;
    rerun.then = then;
    rerun.now = now;
    break;
  }
  return rerun;
}

std::string to_text(const Rerun& r) {
  if (r.differs_at == 0) return fmt::format("{} ticks, identical", r.ticks);
  return fmt::format("tick {} differs\n  then  {}\n  now   {}", r.differs_at, text_of(r.then), text_of(r.now));
}

}  // namespace palp
