#include "sim_server/explain.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace palp {
namespace {

constexpr double kSeconds = 1;  // that a bill is measured for

std::string size_text(double bytes) {
  if (bytes < 1e3) return fmt::format("{:.0f} B", bytes);
  return bytes < 1e6   ? fmt::format("{:.3g} kB", 1e-3 * bytes)
         : bytes < 1e9 ? fmt::format("{:.3g} MB", 1e-6 * bytes)
                       : fmt::format("{:.3g} GB", 1e-9 * bytes);
}

// Rounds to four digits, so that the last bits of another machine do not show.
double rounded(double x) {
  if (!(x > 0)) return x;
  const double unit = std::pow(10, std::floor(std::log10(x)) - 3);
  return std::stod(fmt::format("{:.4g}", std::round(x / unit) * unit));
}

std::string joined(const std::vector<std::string>& parts) {
  std::string out;
  for (const std::string& part : parts) out += (out.empty() ? "" : "; ") + part;
  return out;
}

std::string body_lines(const Bill& bill) {
  std::string out = fmt::format("Particles: {}\n", bill.particles());
  for (const BillBody& body : bill.bodies) {
    const std::string why = body.particles == 0    ? "has none: it meets only bodies, by its distance field"
                            : body.reasons.empty() ? "NOBODY MEETS THEM"
                                                   : joined(body.reasons);
    const std::string far =
        body.out_of_reach > 0 ? fmt::format(" ({} out of any fluid's reach)", body.out_of_reach) : "";
    out += fmt::format("  {:>9}  {:8} {:20} {}{}\n", body.particles, body.kind, body.name, why, far);
  }
  return out;
}

std::string limit_lines(const Bill& bill) {
  std::string out = fmt::format("Sub-steps: {} of {:.4g} ms in a haptic step of {:.4g} ms\n", bill.sub_steps,
                                1e3 * bill.dt, 1e3 * bill.step);
  bool rules = true;
  for (const BillLimit& one : bill.limits) {
    const std::string note = !one.limit.avoided_by.empty() ? fmt::format("  avoided: {}", one.limit.avoided_by)
                             : rules                       ? "  rules"
                                                           : "";
    out += fmt::format("  {:16} at most {:.3g} ms, {:.0f} sub-steps, by {}{}\n", one.limit.by, 1e3 * one.limit.dt,
                       one.sub_steps, one.limit.of, note);
    rules = false;
  }
  return out;
}

std::string stage_lines(const Bill& bill) {
  std::uint64_t launches = 0;
  for (const BillStage& stage : bill.stages) launches += stage.launches;
  std::string out = fmt::format("Launches: {} in a haptic step, {:.4g} ms as measured over {} steps\n", launches,
                                1e3 * bill.stage_seconds(), bill.measured_steps);
  for (const BillStage& stage : bill.stages)
    out += fmt::format("  {:24} {:>5} x {:14} {:6.1f} %  {:.3g} us\n", stage.name, stage.launches,
                       stage.every > 1 ? fmt::format("every {} steps", stage.every) : "a step", 100 * stage.share,
                       1e6 * stage.seconds);
  return out;
}

std::string array_lines(const Bill& bill) {
  std::string out = fmt::format("Memory: {} in {} arrays (the CPU's neighbour lists grow beside them)\n",
                                size_text(static_cast<double>(bill.bytes())), bill.arrays.size());
  auto arrays = bill.arrays;
  std::stable_sort(arrays.begin(), arrays.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  for (const auto& [name, bytes] : arrays)
    out += fmt::format("  {:>9}  {}\n", size_text(static_cast<double>(bytes)), name);
  return out;
}

}  // namespace

std::string text_of(const Bill& bill) {
  std::string out =
      fmt::format("{} on {}: {}\n\n{}\nModules\n", bill.scene, bill.backend, bill.numerics, body_lines(bill));
  for (const BillModule& module : bill.modules) out += fmt::format("  {:24} {}\n", module.name, module.why);
  out += "\n" + limit_lines(bill) + "\n";
  if (bill.measured_steps > 0) out += stage_lines(bill) + "\n";
  out += array_lines(bill);
  if (!bill.hints.empty()) out += "\nWhat would make it cheaper\n";
  for (const std::string& hint : bill.hints) out += fmt::format("  - {}\n", hint);
  return out;
}

Json json_of(const Bill& bill, bool times) {
  Json bodies = Json::array(), modules = Json::array(), limits = Json::array(), stages = Json::array(),
       arrays = Json::array();
  for (const BillBody& body : bill.bodies)
    bodies.push_back({{"name", body.name},
                      {"kind", body.kind},
                      {"particles", body.particles},
                      {"reasons", body.reasons},
                      {"out_of_reach", body.out_of_reach}});
  for (const BillModule& module : bill.modules) modules.push_back({{"name", module.name}, {"why", module.why}});
  for (const BillLimit& one : bill.limits)
    limits.push_back({{"by", one.limit.by},
                      {"of", one.limit.of},
                      {"at_most_ms", rounded(1e3 * one.limit.dt)},
                      {"sub_steps", one.sub_steps},
                      {"avoided_by", one.limit.avoided_by}});
  for (const BillStage& stage : bill.stages) {
    Json line{{"name", stage.name}, {"launches", stage.launches}, {"every_steps", stage.every}};
    if (times) line.update({{"share", stage.share}, {"us_a_step", 1e6 * stage.seconds}});
    stages.push_back(line);
  }
  for (const auto& [name, bytes] : bill.arrays) arrays.push_back({{"name", name}, {"bytes", bytes}});
  Json out{{"scene", bill.scene},
           {"spacing_m", rounded(bill.spacing)},
           {"particles", bill.particles()},
           {"bodies", bodies},
           {"modules", modules},
           {"sub_steps", bill.sub_steps},
           {"step_ms", rounded(1e3 * bill.step)},
           {"limits", limits},
           {"stages", stages},
           {"bytes", bill.bytes()},
           {"arrays", arrays}};
  if (times)
    out.update({{"backend", bill.backend},
                {"numerics", bill.numerics},
                {"measured_steps", bill.measured_steps},
                {"us_a_step", 1e6 * bill.stage_seconds()},
                {"hints", bill.hints}});
  return out;
}

void explain(Simulation& simulation, const std::string& form) {
  const Bill bill = make_bill(simulation, kSeconds);
  if (form == "text")
    fmt::print("{}", text_of(bill));
  else if (form == "json")
    fmt::print("{}", json_text(json_of(bill)));
  else
    write_json(form, json_of(bill));
}

}  // namespace palp
