#include "sim_server/status_reporter.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "idl/clock.h"

namespace palp {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = 200ms;
constexpr auto kLinger = 150ms;  // a Fast DDS reader drops what it has not taken yet when its writer goes
constexpr double kSlowFactor = 0.9;
constexpr double kShareOfPeriod = 0.8;  // a machine whose steps take less would keep up if it were idle
constexpr int kSlowReports = 15;        // 3 s: a scene's first moments say little
constexpr double kFewestParticles = 100;

const char* to_string(ServerState state) {
  return state == ServerState::running ? "running" : state == ServerState::paused ? "paused" : "fault";
}

// Rounds down to two digits.
double rounded(double n) {
  const double unit = std::pow(10, std::floor(std::log10(n)) - 1);
  return std::floor(n / unit) * unit;
}

}  // namespace

std::string advice_for_slow(double real_time_factor, double step_us, const Effort& effort) {
  if (step_us < kShareOfPeriod * effort.period_us)
    return fmt::format(
        "the simulation runs in slow motion, at {:.2f} of real time, though most of its steps take but {:.0f} of "
        "{:.0f} us: other programs keep this machine busy",
        real_time_factor, step_us, effort.period_us);
  // a sub-step's cost grows with the number of particles N, and with the spacing their number a second, as N^(1/3)
  constexpr double kMargin = 0.9;
  const double n = static_cast<double>(effort.particles) * std::pow(kMargin * real_time_factor, 0.75);
  const std::string fewer =
      n >= kFewestParticles
          ? fmt::format("--particles {:.0f} (by estimate what this machine computes in real time)", rounded(n))
          : "";
  const std::string faster = effort.accuracy == Accuracy::fast ? "" : "--accuracy fast";
  const std::string advice = faster.empty() && fewer.empty()
                                 ? "use a faster machine or --backend cuda"
                                 : fmt::format("start palp-sim-server with {}{}{}", faster,
                                               faster.empty() || fewer.empty() ? "" : " or ", fewer);
  return fmt::format("the simulation runs in slow motion, at {:.2f} of real time: {}", real_time_factor, advice);
}

ServerStatusReporter::ServerStatusReporter(Bus& bus, const Gauges& gauges, const Effort& effort, HapticLink& haptic,
                                           const FrameLink& frames, ControlLink& control)
    : gauges_(gauges),
      effort_(effort),
      haptic_(haptic),
      frames_(frames),
      control_(control),
      own_session_(bus.session()),
      statuses_(bus.reader<Status>()),
      thread_([this](const std::stop_token& ended) { run(ended); }) {}

ServerStatusReporter::~ServerStatusReporter() {
  thread_.request_stop();
  thread_.join();
  publish("ended", "", 0);
  std::this_thread::sleep_for(kLinger);
}

void ServerStatusReporter::run(const std::stop_token& ended) {
  while (!ended.stop_requested()) {
    std::this_thread::sleep_for(kPeriod);
    std::vector<Received<Status>> statuses;
    statuses_->take_all(statuses);
    for (const Received<Status>& s : statuses) roster_.add(s);
    roster_.forget(now_ns());
    const ServerState state = gauges_.state;
    publish(to_string(state), find_trouble(), state == ServerState::running ? gauges_.real_time_factor.load() : 0);
  }
}

// All are looked for, for each may have to be warned of; the status has room for the first.
std::string ServerStatusReporter::find_trouble() {
  std::string first;
  for (const std::string& sentence :
       {haptic_.foreign_peer(), find_other_server(), find_second_bridge(), find_slowness(gauges_.real_time_factor)})
    if (first.empty()) first = sentence;
  if (first.empty() && gauges_.doubtful)
    first = fmt::format(
        "the answer is spoilt: the fluid is compressed by {:.2g} % on average, expected at most {:.2g} %; raise "
        "numerics.max_speed",
        100 * gauges_.mean_compression, 100 * gauges_.expected_compression);
  if (first.empty() && gauges_.gone_mass > 0)
    first = fmt::format("outside: {:.3g} kg of fluid have left the domain", gauges_.gone_mass.load());
  return first;
}

void ServerStatusReporter::warn_once(const std::string& sentence, std::uint64_t about, std::uint64_t& warned_about) {
  if (std::exchange(warned_about, about) == about) return;
  spdlog::warn("{}", sentence);
  control_.event(Severity::warning, gauges_.sim_time, sentence);
}

std::string ServerStatusReporter::find_other_server() {
  const Peer* other = roster_.server_beside(own_session_);
  if (!other) return "";
  const std::string sentence = fmt::format(
      "another {} serves in this domain: bridges and viewers hold on to the one that they heard first; end one of the "
      "two, or give it another --domain",
      name_of(other->status));
  warn_once(sentence, other->session(), warned_server_);
  return sentence;
}

std::string ServerStatusReporter::find_second_bridge() {
  const std::optional<NumberHolder> contested = haptic_.contested();
  if (!contested) return "";
  const std::string sentence =
      fmt::format("device number {} is held by {}: {} uses the same number and moves nothing", contested->device,
                  roster_.name_of_session(contested->holder), roster_.name_of_session(contested->refused));
  warn_once(sentence, contested->refused, warned_bridge_);
  return sentence;
}

std::string ServerStatusReporter::find_slowness(double real_time_factor) {
  const std::uint64_t slow = gauges_.slow_steps;
  const bool is_slow = effort_.paced && gauges_.state == ServerState::running && real_time_factor < kSlowFactor &&
                       slow > std::exchange(last_slow_steps_, slow);
  slow_in_a_row_ = is_slow ? slow_in_a_row_ + 1 : 0;
  if (!is_slow) return "";
  const std::string sentence = advice_for_slow(real_time_factor, gauges_.step_time.quantile_us(0.5), effort_);
  if (slow_in_a_row_ >= kSlowReports) warn_once(sentence, 1, warned_slow_);
  return sentence;
}

void ServerStatusReporter::publish(const std::string& state, const std::string& text, double real_time_factor) {
  control_.status(state, text,
                  {{"sim_time_s", gauges_.sim_time},
                   {"steps", static_cast<double>(gauges_.steps)},
                   {"real_time_factor", real_time_factor},
                   {"step_p50_us", gauges_.step_time.quantile_us(0.5)},
                   {"step_p99_us", gauges_.step_time.quantile_us(0.99)},
                   {"step_max_us", gauges_.step_time.max_us()},
                   {"handover_p50_us", gauges_.handover.quantile_us(0.5)},
                   {"handover_p99_us", gauges_.handover.quantile_us(0.99)},
                   {"slow_steps", static_cast<double>(gauges_.slow_steps)},
                   {"max_speed_m_s", gauges_.max_speed},
                   {"max_compression", gauges_.max_compression},
                   {"expected_speed_m_s", gauges_.expected_speed},
                   {"mean_compression", gauges_.mean_compression},
                   {"expected_compression", gauges_.expected_compression},
                   {"kinetic_energy_J", gauges_.kinetic_energy},
                   {"outside_particles", static_cast<double>(gauges_.outside)},
                   {"gone_kg", gauges_.gone_mass},
                   {"frames", static_cast<double>(frames_.sent())},
                   {"shared_frames", static_cast<double>(frames_.shared())},
                   {"dropped_samples", static_cast<double>(haptic_.dropped() + control_.dropped())}});
}

}  // namespace palp
