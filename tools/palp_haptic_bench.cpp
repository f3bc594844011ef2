// Measures the haptic loop in lock-step: the solver, the server's hand, a link each way, the bridge's loop and a
// simulated arm in a simulated hand. One table, each result beside its reference and target.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "config/command_line.h"
#include "config/data_dir.h"
#include "config/json_file.h"
#include "config/number_between.h"
#include "idl/bus.h"
#include "sim_server/scene_options.h"
#include "sim_server/threads/thread_team.h"
#include "tools/haptic_bench/bench_scenes.h"
#include "tools/haptic_bench/bus_time.h"
#include "tools/haptic_bench/jobs.h"
#include "tools/haptic_bench/metrics.h"
#include "tools/haptic_bench/results.h"
#include "tools/haptic_bench/tick_cost.h"

namespace palp::bench {
namespace {

struct Arguments {
  bool quick = false;
  std::vector<std::string> metrics, hand_names, link_names, variants;
  std::vector<double> rates{1000, 500, 300}, dampings{0, 5, 20};
  std::uint64_t seed = 1;
  int seeds = 3;
  unsigned jobs = static_cast<unsigned>(usable_processors());
  std::string out, json, trace, series, command;
  std::string profile = "simulated";
  std::optional<Accuracy> accuracy;  // of figure 4's trays
  double stiffness = 0;              // of the profile, if 0
  std::optional<double> slew, friction;
  bool uncontrolled = false;
  std::size_t ticks = 0;  // to measure the cost of
  double bus = 0;         // to measure for [s]
  int domain = 0;
  std::string part;  // "k/n"
  std::vector<std::string> merge;
};

Variant variant_from(const std::string& name) {
  return name == "ours" ? Variant::ours : name == "held" ? Variant::held : Variant::spring;
}

std::string name_of(const Cell& c) {
  return fmt::format("hand {}, {:.0f} Hz, link {}, {}", c.hand.name, c.rate_hz, c.link.name, to_string(c.variant));
}

// Where a metric is measured by default: on the link of one host at the first rate; on the listed links, and on further
// ones at the first rate; on further ones at the last rate, too.
enum class Where { one_host, links, more_links };

struct Metric {
  std::string name;
  std::vector<std::string> hand_names, variants;  // by default
  Where where;
  std::function<std::vector<Row>(const Scenes&, const Cell&, const Arguments&)> rows;
};

const std::vector<Metric>& metrics() {
  static const std::vector<Metric> kMetrics{
      {"z_width",
       {"off", "light", "firm"},
       {"ours", "held", "spring"},
       Where::more_links,
       [](const Scenes& s, const Cell& c, const Arguments& a) {
         return z_width_rows(s.wall, c, a.dampings, !a.quick);
       }},
      {"torsion",
       {"off", "light", "firm"},
       {"ours", "held"},
       Where::links,
       [](const Scenes& s, const Cell& c, const Arguments& a) { return torsion_rows(s, c, a.dampings, !a.quick); }},
      {"minute",
       {"light"},
       {"ours", "held"},
       Where::links,
       [](const Scenes& s, const Cell& c, const Arguments& a) { return minute_rows(s, c, a.quick ? 30 : 60); }},
      {"buzz",
       {"off", "light", "firm"},
       {"ours", "held"},
       Where::links,
       [](const Scenes& s, const Cell& c, const Arguments&) { return buzz_rows(s, c); }},
      {"drag",
       {"off", "light", "firm"},
       {"ours", "held", "spring"},
       Where::more_links,
       [](const Scenes& s, const Cell& c, const Arguments&) { return drag_rows(s, c); }},
      {"current",
       {"light"},
       {"ours", "held", "spring"},
       Where::links,
       [](const Scenes& s, const Cell& c, const Arguments&) { return current_rows(s, c); }},
      {"rendering",
       {"off", "light", "firm"},
       {"ours", "held", "spring"},
       Where::more_links,
       [](const Scenes& s, const Cell& c, const Arguments&) { return rendering_rows(s, c); }},
      {"delay",
       {"light"},
       {"ours"},
       Where::links,
       [](const Scenes& s, const Cell& c, const Arguments&) { return delay_rows(s, c); }},
      {"figure4",
       {"firm"},
       {"ours"},
       Where::one_host,
       [](const Scenes&, const Cell& c, const Arguments& a) { return figure4_rows(c, a.accuracy, a.series); }},
      {"fault",
       {"firm"},
       {"ours"},
       Where::more_links,
       [](const Scenes& s, const Cell& c, const Arguments&) { return fault_rows(s, c); }},
  };
  return kMetrics;
}

std::vector<std::string> given_or(const std::vector<std::string>& given, const std::vector<std::string>& otherwise) {
  return given.empty() ? otherwise : given;
}

bool has(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

DeviceProfile profile_of(const Arguments& a) {
  DeviceProfile profile = read_device_profile(find_data_file(kDeviceProfiles, a.profile));
  profile.loop.limits.force_slew = a.slew.value_or(profile.loop.limits.force_slew);
  profile.setup<ArmModel>().friction = a.friction.value_or(profile.setup<ArmModel>().friction);
  if (a.stiffness > 0) profile.loop.gains.stiffness = a.stiffness;
  return profile;
}

// Returns whether a further link, which nobody asked for by name, is measured at this rate and with this variant: no
// baselines are, and only the fastest rate is, or that and the slowest.
bool on_further_link(const Arguments& a, const Metric& metric, double rate, const std::string& variant) {
  return variant == "ours" &&
         (rate == a.rates.front() || (metric.where == Where::more_links && rate == a.rates.back()));
}

std::vector<Cell> cells_of(const Arguments& a, const Metric& metric) {
  const DeviceProfile profile = profile_of(a);
  std::vector<std::string> links = listed_links();
  if (!a.quick) links.insert(links.end(), further_links().begin(), further_links().end());
  const bool one_host = metric.where == Where::one_host;
  if (one_host) links = {"local"};
  const std::vector<double> rates = one_host ? std::vector{a.rates.front()} : a.rates;
  std::vector<Cell> cells;
  for (const std::string& hand : given_or(a.hand_names, metric.hand_names))
    for (const double rate : rates)
      for (const std::string& link : given_or(a.link_names, links))
        for (const std::string& variant : given_or(a.variants, metric.variants))
          if (!a.link_names.empty() || has(listed_links(), link) || on_further_link(a, metric, rate, variant))
            cells.push_back({hand_named(hand), rate, link_from(link), variant_from(variant), a.seed, a.seeds, profile,
                             !a.uncontrolled});
  return cells;
}

// Writes one press of the first cell, tick by tick.
void write_press(const Arguments& a, const Scene& wall) {
  const Cell cell = cells_of(a, metrics().front()).front();
  const Trace trace = run(wall_press(wall, cell, cell.profile.loop.gains.stiffness, a.dampings.front(), a.seed));
  std::string text =
      "t_s,z_m,v_m_s,turn_rad,force_z_N,force_x_N,torque_Nm,port_J,put_in_J,blend,delay_s,state,verdict,share,"
      "energy_J,damping\n";
  for (const Tick& t : trace.ticks)
    text += fmt::format(
        "{:.3f},{:.7f},{:.5f},{:.6f},{:.4f},{:.4f},{:.5f},{:.6f},{:.6f},{:.3f},{:.5f},{},{},{:.3f},{:.6f},{:.3f}\n",
        t.t, t.x.z(), t.v.z(), t.turn.norm(), t.force.z(), t.force.x(), t.torque.norm(), t.port[0], t.put_in[0],
        t.blend, t.delay, palp::to_string(t.state), t.verdict, t.share, t.energy, t.damping);
  write_text("trace", a.trace, text);
  fmt::print("{}: {} ticks, {} sub-steps a step{}\n", name_of(cell), trace.ticks.size(), trace.sub_steps,
             trace.trouble.empty() ? "" : ", " + trace.trouble);
}

// Notes beside each stiffness of ours how many times the held wrench's that is.
void compare(std::vector<Row>& rows) {
  for (Row& r : rows) {
    if (r.variant != to_string(Variant::ours) || (r.unit != "kN/m" && r.unit != "N m/rad")) continue;
    for (const Row& held : rows)
      if (held.variant == to_string(Variant::held) && held.metric == r.metric && held.hand == r.hand &&
          held.link == r.link && held.rate_hz == r.rate_hz && held.result > 0)
        r.note = fmt::format("{:.2g} times the held wrench; {}", r.result / held.result, r.note);
  }
}

std::string processor_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown";
}

// Returns the link of that name as the command line has it.
std::string spelled(const Arguments& a, const std::string& name) {
  for (const std::string& text : a.link_names)
    if (text.substr(0, text.find(':')) == name) return text;
  return name;
}

std::vector<std::string> preface(const Arguments& a, const std::vector<Row>& rows) {
  std::size_t judged = 0, good = 0;
  for (const Row& r : rows)
    if (r.pass) ++judged, good += *r.pass;
  std::set<std::string> named;
  std::string links;
  for (const Row& r : rows)
    if (named.insert(r.link).second)
      links += (links.empty() ? "" : "; ") + r.link + ": " + description_of(spelled(a, r.link));
  return {
      fmt::format("`{}`: the solver, the server's treatment of samples, a link each way, the bridge's loop at 1 kHz "
                  "and a simulated arm in a simulated hand, in lock-step. {} of {} targets are met. The same "
                  "seeds give the same table on any machine of this kind ({}).",
                  a.command, good, judged, processor_name()),
      "Links, times in ms, each way: " + links + "."};
}

std::vector<Row> measured(const Arguments& a, const Scenes& scenes) {
  std::vector<Job> jobs;
  for (const Metric& m : metrics())
    if (a.metrics.empty() || has(a.metrics, m.name))
      for (const Cell& c : cells_of(a, m))
        jobs.push_back({0, fmt::format("{}, {}", m.name, name_of(c)), [&, c] { return m.rows(scenes, c, a); }});
  return work_off(part_of(std::move(jobs), a.part), a.jobs);
}

int measure(Arguments a) {
  if (a.bus > 0) {
    fmt::print("{}", markdown(bus_times(a.domain, a.bus)));
    return 0;
  }
  if (a.ticks > 0) {
    fmt::print("{}", markdown(tick_costs(profile_of(a), find_own_library("libvirtuose_sim.so"), a.ticks)));
    return 0;
  }
  const RoomForResults room({a.out, a.json, a.trace});
  std::vector<Row> rows;
  if (!a.merge.empty()) {
    a.command.clear();
    rows = merged(a.merge, a.command);
  } else {
    const Scenes scenes{wall_scene(), elastic_scene(), current_scene(), tank_scene(), vise_scene()};
    if (!a.trace.empty()) {
      write_press(a, scenes.wall);
      return 0;
    }
    rows = measured(a, scenes);
  }
  if (a.part.empty()) compare(rows);
  const std::string table = markdown(rows, preface(a, rows));
  if (a.out.empty())
    fmt::print("{}", table);
  else
    write_text("table", a.out, table);
  if (!a.json.empty())
    write_json(a.json,
               {{"command", a.command}, {"processor", processor_name()}, {"seed", a.seed}, {"rows", json_of(rows)}});
  return 0;
}

}  // namespace
}  // namespace palp::bench

int main(int argc, char** argv) {
  CLI::App app("Measures the haptic loop in lock-step over the full system.");
  palp::bench::Arguments a;
  app.add_flag("--quick", a.quick, "One seed, one damping, coarse steps, coarse trays");
  std::vector<std::string> names;
  for (const palp::bench::Metric& m : palp::bench::metrics()) names.push_back(m.name);
  app.add_option("--metric", a.metrics, fmt::format("{} (default: all)", fmt::join(names, ", ")))
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  app.add_option("--hand", a.hand_names, "off, light, firm (default: all)")->delimiter(',');
  app.add_option("--rate", a.rates, "Rates of the server [Hz]")
      ->delimiter(',')
      ->check(palp::number_between(50.0, 4000.0));
  app.add_option("--link", a.link_names, "Names, or NAME:delay=2,jitter=1,loss=0.02 (times in ms)");
  app.add_option("--variant", a.variants, "ours, held, spring")
      ->delimiter(',')
      ->check(CLI::IsMember({"ours", "held", "spring"}));
  app.add_option("--damping", a.dampings, "Of the coupling, for the Z-width [N s/m]")
      ->delimiter(',')
      ->check(palp::number_between(0.0, 1e4));
  app.add_option("--seed", a.seed, "Of links and beats");
  app.add_option("--seeds", a.seeds, "How many to try; the worst counts")->check(CLI::Range(1, 1000));
  app.add_option("--jobs", a.jobs, "Threads")->check(CLI::Range(1, 1024));
  app.add_option("--out", a.out, "Markdown file (default: standard output)");
  app.add_option("--trace", a.trace, "CSV file: one press on the wall in the first cell, and nothing else");
  app.add_option("--series", a.series, "Folder for what metric figure4 felt, a CSV file a tray")
      ->check(CLI::ExistingDirectory);
  palp::add_accuracy_option(app, a.accuracy);
  app.add_option("--stiffness", a.stiffness, "Of the coupling, instead of the profile's; not for the Z-width [N/m]")
      ->check(palp::number_between(0, 1e5));
  app.add_option("--profile", a.profile, "Device profile, a name or a file: limits, gains, simulated arm");
  app.add_option("--slew", a.slew, "The loop's force slew limit [N/s]")->check(palp::number_between(1, 1e5));
  app.add_flag("--uncontrolled", a.uncontrolled, "Without passivity control and gains that follow the delay");
  app.add_option("--friction", a.friction, "Coulomb friction of the arm [N]")->check(palp::number_between(0, 50));
  app.add_option("--ticks", a.ticks,
                 "CPU time of so many ticks of the bridge's loop with each device, and nothing else")
      ->check(CLI::Range(1u, 10'000'000u));
  app.add_option("--bus", a.bus,
                 "Time of samples over DDS between two processes of this host for so many seconds, and nothing else")
      ->check(palp::number_between(0.1, 3600));
  app.add_option("--domain", a.domain, "DDS domain of --bus")->check(CLI::Range(0, palp::kMaxDomain));
  app.add_option("--json", a.json, "JSON file");
  app.add_option("--part", a.part, "k/n: every n-th job from the k-th on; with --json, to be merged");
  app.add_option("--merge", a.merge, "JSON files of parts: their table, and nothing is measured")
      ->check(CLI::ExistingFile);
  return palp::run_program("palp-haptic-bench", app, argc, argv, [&] {
    if (a.quick) {
      if (app.count("--seeds") == 0) a.seeds = 1;
      if (app.count("--damping") == 0) a.dampings = {5};
      if (!a.accuracy) a.accuracy = palp::Accuracy::fast;
    }
    a.command = "palp-haptic-bench";
    for (int k = 1; k < argc; ++k) a.command += std::string(" ") + argv[k];
    return palp::bench::measure(a);
  });
}
