// Runs cells of the stability map (tools/stability_map) side by side and says how each ended. Exit status: 3 where a
// cell is neither bounded nor refused with what to change. tools/stability makes the page of it.
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include <unistd.h>

#include "config/command_line.h"
#include "config/json_file.h"
#include "config/number_between.h"
#include "sim_server/scene_options.h"
#include "sim_server/threads/thread_team.h"
#include "tools/stability_map/cells.h"
#include "tools/stability_map/run_cell.h"
#include "tools/stability_map/setup.h"

namespace {

using palp::stability::CellResult;
using palp::stability::End;

constexpr int kExitFault = 3;

struct Arguments {
  bool list = false, all = false, verbose = false;
  std::string only, json, keep;
  std::vector<std::string> cells;
  std::uint64_t random = 0, seed = 1, skip = 0;
  double hours = 0;
  unsigned threads = static_cast<unsigned>(palp::usable_processors());
  palp::Backend backend = palp::Backend::automatic;
  palp::stability::RunLimits limits;
};

// The names of the cells to run, in order: a list, or random ones for a time.
class Names {
 public:
  explicit Names(const Arguments& a) : a_(a), start_(std::chrono::steady_clock::now()) {
    if (!a.cells.empty()) {
      list_ = a.cells;
      for (const std::string& cell : list_) palp::stability::setup_of(cell);  // on the main thread, which can refuse it
    } else if (a.random == 0 && a.hours == 0) {
      const std::regex only(a.only);
      for (const std::string& cell : palp::stability::listed_cells(a.all))
        if (std::regex_search(cell, only)) list_.push_back(cell);
    }
  }
  const std::vector<std::string>& list() const { return list_; }
  // Returns the k-th name; empty: there is none.
  std::string name(std::uint64_t k) const {
    if (!list_.empty()) return k < list_.size() ? list_[k] : "";
    const std::chrono::duration<double> past = std::chrono::steady_clock::now() - start_;
    const bool more = a_.hours > 0 ? past.count() < 3600 * a_.hours : k < a_.random;
    return more ? palp::stability::random_cell(a_.seed, a_.skip + k) : "";
  }

 private:
  const Arguments& a_;
  std::chrono::steady_clock::time_point start_;
  std::vector<std::string> list_;
};

void tell(const CellResult& r, bool verbose) {
  const bool fault = r.end == End::fault;
  if (!fault && !verbose) return;
  fmt::print(
      "{}{} {}\n    {} particles, {} steps of {} sub-steps, {:.3g} s; energy {:.2g}, momentum {:.2g}, heat {:.2g} "
      "of what is allowed; {:.2f} s\n",
      to_string(r.end), r.cause.empty() ? "" : " (" + r.cause + "):", r.cell, r.particles, r.steps, r.sub_steps, r.time,
      r.energy, r.momentum, r.heat, r.seconds);
  if (!r.text.empty()) fmt::print("    {}\n", r.text);
  if (!r.plan.empty()) fmt::print("    {}\n", r.plan);
  std::fflush(stdout);
}

// Runs all cells on so many threads, each simulation on one thread. Returns the results in the order of the names.
std::vector<CellResult> work_off(const Names& names, const Arguments& a, const std::string& folder) {
  std::vector<CellResult> results;
  std::atomic<std::uint64_t> next{0};
  std::mutex talk;
  const auto serve = [&](unsigned thread) {
    for (;;) {
      const std::uint64_t k = next++;
      const std::string name = names.name(k);
      if (name.empty()) return;
      const std::string file = a.keep.empty() ? fmt::format("cell_{}", thread) : fmt::format("cell_{}", k);
      CellResult result = run_cell(name, a.backend, a.limits, folder, file);
      const std::lock_guard lock(talk);
      tell(result, a.verbose);
      if (results.size() <= k) results.resize(k + 1);
      results[k] = std::move(result);
    }
  };
  std::vector<std::thread> pool;
  for (unsigned t = 0; t < a.threads; ++t) pool.emplace_back(serve, t);
  for (std::thread& t : pool) t.join();
  return results;
}

palp::Json json_of(const std::vector<CellResult>& results, const Arguments& a) {
  palp::Json cells = palp::Json::array();
  const auto rounded = [](double x) { return std::stod(fmt::format("{:.3g}", x)); };
  for (const CellResult& r : results) {
    palp::Json cell{{"cell", r.cell}, {"end", to_string(r.end)}};
    if (!r.cause.empty()) cell["cause"] = r.cause;
    if (!r.text.empty()) cell["text"] = r.text;
    if (r.steps > 0) {
      cell["particles"] = r.particles;
      cell["steps"] = r.steps;
      cell["sub_steps"] = r.sub_steps;
      cell["energy"] = rounded(r.energy);
      cell["momentum"] = rounded(r.momentum);
    }
    cell["seconds"] = rounded(r.seconds);
    cells.push_back(std::move(cell));
  }
  palp::Json json{{"version", palp::version_of("palp-stability")},
                  {"backend", a.backend == palp::Backend::cuda ? "cuda" : "cpu"}};
  if (a.random > 0 || a.hours > 0) json["seed"] = a.seed;
  json["cells"] = std::move(cells);
  return json;
}

void sum_up(const std::vector<CellResult>& results, const Arguments& a) {
  std::size_t count[4] = {};
  double seconds = 0;
  for (const CellResult& r : results) {
    ++count[static_cast<int>(r.end)];
    seconds += r.seconds;
  }
  if (a.random > 0 || a.hours > 0) fmt::print("seed {}, cells {} to {}: ", a.seed, a.skip, a.skip + results.size() - 1);
  fmt::print("{} cells: {} bounded, {} refused, {} faults, {} too long; {:.0f} s of one core\n", results.size(),
             count[0], count[1], count[2], count[3], seconds);
}

int run(const Arguments& a) {
  const Names names(a);
  if (a.list) {
    for (const std::string& name : names.list()) fmt::print("{}\n", name);
    return 0;
  }
  const std::string folder =
      a.keep.empty() ? fmt::format("{}/palp_stability_{}", std::filesystem::temp_directory_path().string(), getpid())
                     : a.keep;
  std::filesystem::create_directories(folder);
  const std::vector<CellResult> results = work_off(names, a, folder);
  if (a.keep.empty()) std::filesystem::remove_all(folder);
  if (!a.json.empty()) palp::write_json(a.json, json_of(results, a));
  sum_up(results, a);
  const bool fault =
      std::any_of(results.begin(), results.end(), [](const CellResult& r) { return r.end == End::fault; });
  return fault ? kExitFault : 0;
}

void declare(CLI::App& app, Arguments& a) {
  app.add_flag("--list", a.list, "print the cells' names and run none");
  app.add_flag("--all", a.all, "thousands of cells, not only the hundreds that CI runs");
  app.add_option("--only", a.only, "only cells whose name holds this regular expression");
  app.add_option("--cell", a.cells, "these cells, listed or not: FAMILY/modules=fluid+static/viscosity=1e4/...");
  app.add_option("--random", a.random, "so many random products of the axes, instead of the listed cells");
  app.add_option("--hours", a.hours, "random products for so long")->check(palp::number_between(0.0, 1000.0));
  app.add_option("--seed", a.seed, "of the random products");
  app.add_option("--skip", a.skip, "random products of this seed to leave out first");
  app.add_option("--work", a.limits.work, "work of each cell over the default, which is about half a second")
      ->check(palp::number_between(0.01, 1e6));
  app.add_option("--most", a.limits.most, "cells that need more than so much work for two steps are too long")
      ->check(palp::number_between(0.01, 1e6));
  app.add_option("--threads", a.threads, "cells at a time")->check(CLI::Range(1, 1000));
  app.add_option("--json", a.json, "file for all results");
  app.add_option("--keep", a.keep, "folder for the scenes' files, which are else deleted");
  app.add_flag("--verbose", a.verbose, "tell of each cell, not only of faults");
  palp::add_backend_option(app, a.backend);
}

}  // namespace

int main(int argc, char** argv) {
  setenv("OMP_NUM_THREADS", "1", 1);  // cells run side by side instead
  CLI::App app("Runs the cells of the stability map: each must end bounded or refused with what to change.");
  Arguments a;
  declare(app, a);
  return palp::run_program("palp-stability", app, argc, argv, [&] { return run(a); });
}
