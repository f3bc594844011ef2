// palp-record: records the traffic of a palp system to an MCAP file, or repairs a recording that was cut short.
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "config/command_line.h"
#include "config/json_file.h"
#include "config/number_between.h"
#include "config/stop_signal.h"
#include "idl/bus_options.h"
#include "tools/recording/info.h"
#include "tools/recording/recorder.h"
#include "tools/recording/recover_recording.h"
#include "tools/recording/topic_choice.h"

namespace palp {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  RecorderOptions recorder;
  std::vector<std::string> topics;
  std::vector<std::string> decimation;
  std::string recover;
  std::string info;
  std::string summary;
  double seconds = 0;
  double queue_mb = 256;
};

void add_options(CLI::App& app, Options& o) {
  auto* out =
      app.add_option("-o,--out", o.recorder.path, "the recording (.mcap); written as FILE.tmp~ until it is whole")
          ->type_name("FILE");
  app.add_flag("--overwrite", o.recorder.overwrite, "replace an existing recording");
  app.add_option("--topics", o.topics, "record only these, separated by commas: proxy,particles,...")->delimiter(',');
  app.add_option("--seconds", o.seconds, "end after this time; else with Ctrl-C")->check(number_between(1e-3, 1e9));
  app.add_option("--decimate", o.decimation, "TOPIC=N keeps every N-th message, of particles every N-th frame")
      ->delimiter(',');
  app.add_option("--queue-mb", o.queue_mb, "memory between the bus and the disk [MB]")
      ->check(number_between(1.0, 65536.0))
      ->capture_default_str();
  app.add_option("--summary", o.summary, "write the counts to this file as JSON")->type_name("FILE");
  auto* recover = app.add_option("--recover", o.recover, "give a recording that was cut short a new index, then end")
                      ->type_name("FILE")
                      ->group("Recordings that exist already");
  auto* info = app.add_option("--info", o.info, "say what a recording contains, then end")
                   ->type_name("FILE")
                   ->group("Recordings that exist already");
  info->excludes(out)->excludes(recover);
  add_bus_options(app, o.recorder.bus);
}

int recover(const Options& o) {
  const std::string to = o.recorder.path.empty() ? recovered_name(o.recover) : o.recorder.path;
  const Recovery recovery = recover_recording(o.recover, to, o.recorder.overwrite);
  for (const std::string& damage : recovery.damages) fmt::print(stderr, "palp-record: {}\n", damage);
  fmt::print("{}: {} messages recovered\n", to, recovery.messages);
  return 0;
}

void show_progress(const Recorder& recorder, Clock::duration since_start, bool terminal) {
  const TopicCounts total = recorder.counts().total();
  fmt::print(stderr, "{}recording {:5.0f} s  {} writers  {:9} messages  {:8.1f} MB  {} dropped{}", terminal ? "\r" : "",
             std::chrono::duration<double>(since_start).count(), recorder.writers(), total.messages,
             static_cast<double>(total.bytes) * 1e-6, total.dropped, terminal ? "   " : "\n");
}

Json json_of(const RecordingCounts& counts, bool healthy) {
  const TopicCounts total = counts.total();
  Json json{{"messages", total.messages}, {"bytes", total.bytes}, {"drops", total.dropped},
            {"lost", total.lost},         {"healthy", healthy},   {"topics", Json::object()}};
  for (const auto& [topic, c] : counts.topics)
    json["topics"][topic->name] = {{"messages", c.messages}, {"drops", c.dropped}, {"lost", c.lost}};
  return json;
}

int record(const Options& o) {
  catch_stop_signals();
  Recorder recorder(o.recorder);
  const auto start = Clock::now();
  const bool terminal = isatty(STDERR_FILENO) == 1;
  const auto every = terminal ? std::chrono::milliseconds(500) : std::chrono::milliseconds(5000);
  auto next_progress = start + every;
  int writers = 0;
  std::size_t servers = 0;
  while (!stop_asked() && !recorder.failed()) {
    const auto now = Clock::now();
    if (o.seconds > 0 && now - start >= std::chrono::duration<double>(o.seconds)) break;
    if (const int known = recorder.writers(); known != writers || now >= next_progress) {
      show_progress(recorder, now - start, terminal);
      writers = known;
      next_progress = now + every;
    }
    recorder.poll(std::chrono::milliseconds(50));
    if (recorder.servers_at_once() > servers) {
      servers = recorder.servers_at_once();
      fmt::print(
          stderr,
          "{}palp-record: {} servers run in one domain: {}; end all but one, or give each a --domain of its own\n",
          terminal ? "\n" : "", servers, kServersTogether);
    }
  }
  if (!recorder.failed()) recorder.poll(std::chrono::milliseconds(0));  // what came before the stop
  if (terminal) fmt::print(stderr, "\n");
  const RecordingCounts counts = recorder.counts();
  std::string failure;
  try {
    recorder.finish();
  } catch (const McapError& error) {
    failure = error.what();
  }
  const TopicCounts total = counts.total();
  if (!failure.empty()) fmt::print(stderr, "palp-record: {}\n", failure);
  if (!o.summary.empty()) write_json(o.summary, json_of(counts, failure.empty() && total.dropped == 0));
  if (!failure.empty()) return 1;
  fmt::print("{}: {} messages, {:.1f} MB in {:.1f} s, {} dropped, {} lost on the way\n", o.recorder.path,
             total.messages, static_cast<double>(total.bytes) * 1e-6,
             std::chrono::duration<double>(Clock::now() - start).count(), total.dropped, total.lost);
  for (const auto& [topic, c] : counts.topics)
    if (c.messages > 0 || c.dropped > 0)
      fmt::print("  {:20} {:9} messages  {:8.2f} MB  {} dropped\n", topic->name, c.messages,
                 static_cast<double>(c.bytes) * 1e-6, c.dropped);
  return 0;
}

int run(Options& o) {
  if (!o.info.empty()) {
    fmt::print("{}", describe_recording(o.info));
    return 0;
  }
  if (!o.recover.empty()) return recover(o);
  if (o.recorder.path.empty()) throw ConfigError("--out FILE is needed: where the recording goes");
  o.recorder.topics = choose_topics(o.topics);
  o.recorder.decimation = parse_decimation(o.decimation);
  o.recorder.queue_bytes = static_cast<std::size_t>(o.queue_mb * 1e6);
  return record(o);
}

}  // namespace
}  // namespace palp

int main(int argc, char** argv) {
  CLI::App app("Records what palp's processes say to each other to an MCAP file, or repairs a recording.");
  palp::Options options;
  palp::add_options(app, options);
  return palp::run_program("palp-record", app, argc, argv, [&] { return palp::run(options); });
}
