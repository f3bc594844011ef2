// palp-replay: plays a recording back onto the bus.
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "config/command_line.h"
#include "config/number_between.h"
#include "config/stop_signal.h"
#include "idl/bus_options.h"
#include "tools/recording/replayer.h"
#include "tools/recording/topic_choice.h"

namespace palp {
namespace {

// Waits for one line from the keyboard; false at its end or when the program is asked to stop.
bool wait_for_enter() {
  while (!stop_asked()) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, 100) <= 0) continue;
    char c = 0;
    while (read(STDIN_FILENO, &c, 1) == 1)
      if (c == '\n') return true;
    return false;
  }
  return false;
}

// Says what a damaged recording cost. Throws std::runtime_error when it cost anything.
void check_whole(const ReplayCounts& counts, const std::string& path) {
  if (counts.lost_chunks == 0) return;
  throw std::runtime_error(fmt::format(
      "{}: {} in {} damaged chunk{}; palp-record --recover {} copies what is whole into a new recording", path,
      counts.lost_messages > 0 ? fmt::format("{} messages are lost", counts.lost_messages) : "messages are lost",
      counts.lost_chunks, counts.lost_chunks == 1 ? "" : "s", path));
}

void declare(CLI::App& app, ReplayOptions& options, std::vector<std::string>& topics) {
  app.add_option("file", options.path, "a recording (.mcap)")->required();
  auto* rate = app.add_option("--rate", options.rate, "times the original pace; 0: as fast as possible")
                   ->check(number_between(0.0, 1e6))
                   ->capture_default_str();
  const std::map<std::string, Step> steps{{"message", Step::message}, {"time", Step::time}};
  app.add_option("--step", options.step, "Enter plays the next message, or all of the next haptic time step")
      ->transform(CLI::CheckedTransformer(steps, CLI::ignore_case).description(""))
      ->type_name("message|time")
      ->excludes(rate);
  app.add_option("--topics", topics, "play only these, separated by commas: proxy,particles,...")->delimiter(',');
  app.add_flag("--loop", options.loop, "begin again at the end, until Ctrl-C");
  app.add_option("--wait-readers", options.wait_readers, "wait until so many readers, over all topics, are there")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--timeout", options.wait_seconds, "give up waiting for readers after this time [s]")
      ->check(number_between(0.0, 1e6))
      ->capture_default_str();
  add_bus_options(app, options.bus);
}

int run(ReplayOptions& options, const std::vector<std::string>& topics) {
  options.topics = choose_topics(topics);
  catch_stop_signals();
  const auto say_damage = [](const std::string& damage) {
    fmt::print(stderr, "palp-replay: {}; this chunk is left out\n", damage);
  };
  const ReplayCounts counts = replay(options, {stop_asked, wait_for_enter, say_damage});
  fmt::print("{} messages played", counts.messages);
  if (options.step == Step::none && options.rate > 0)
    fmt::print(", lateness median {:.0f} us, 99 % below {:.0f} us, at most {:.0f} us", counts.lateness_p50_us,
               counts.lateness_p99_us, counts.lateness_max_us);
  fmt::print("\n");
  if (counts.refused > 0) throw std::runtime_error(fmt::format("{} messages were refused by the bus", counts.refused));
  check_whole(counts, options.path);
  return 0;
}

}  // namespace
}  // namespace palp

int main(int argc, char** argv) {
  CLI::App app(
      "Plays a recording back onto the bus, byte for byte: into viewers, bridges, servers and recorders of the same "
      "domain.");
  palp::ReplayOptions options;
  std::vector<std::string> topics;
  palp::declare(app, options, topics);
  return palp::run_program("palp-replay", app, argc, argv, [&] { return palp::run(options, topics); });
}
