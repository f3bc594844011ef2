#include "tools/control_text.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <sstream>

namespace palp {
namespace {

// The figures that tell how a process fares, of all that it publishes.
struct Figure {
  const char* metric;
  const char* format;
};
constexpr std::array<Figure, 6> kFigures{{{"real_time_factor", "x{:.2f} real time"},
                                          {"step_p50_us", "step {:.0f} us"},
                                          {"rate_hz", "{:.0f} Hz"},
                                          {"force_n", "{:.2f} N"},
                                          {"sample_age_p50_ms", "data {:.1f} ms old"},
                                          {"shown_rate_hz", "{:.0f} pictures/s"}}};

double age_of(const Peer& peer, std::int64_t now_ns) { return 1e-9 * static_cast<double>(now_ns - peer.t_receive_ns); }

}  // namespace

std::string line_of(const Peer& peer, std::int64_t now_ns) {
  std::string figures;
  for (const Figure& figure : kFigures)
    for (const Metric& m : peer.status.metrics)
      if (m.name == figure.metric) figures += fmt::format(fmt::runtime(figure.format), m.value) + ", ";
  return fmt::format("{}: {}, {}heard {:.1f} s ago{}{}", name_of(peer.status), peer.status.state, figures,
                     age_of(peer, now_ns), peer.status.text.empty() ? "" : "; ", peer.status.text);
}

Json json_of(const Peer& peer, std::int64_t now_ns) {
  Json json{
      {"process", peer.status.process}, {"name", name_of(peer.status)}, {"session", std::to_string(peer.session())},
      {"state", peer.status.state},     {"text", peer.status.text},     {"age_s", age_of(peer, now_ns)},
      {"metrics", Json::object()}};
  for (const Metric& m : peer.status.metrics) json["metrics"][m.name] = m.value;
  return json;
}

std::vector<ListedParameter> parse_parameters(const std::string& text) {
  std::vector<ListedParameter> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    ListedParameter p;
    for (std::string* cell : {&p.name, &p.value, &p.unit, &p.low, &p.high}) std::getline(cells, *cell, '\t');
    out.push_back(p);
  }
  return out;
}

std::string line_of(const ListedParameter& p) {
  const std::string value = p.value.empty() ? "as the accuracy level derives it" : p.value;
  return fmt::format("{} = {}{}{}{}", p.name, value, p.unit.empty() ? "" : " ", p.unit,
                     p.low.empty() ? "" : fmt::format(" ({} to {})", p.low, p.high));
}

Json json_of(const ListedParameter& p) {
  Json json{{"name", p.name}, {"value", p.value}, {"unit", p.unit}};
  if (!p.low.empty()) json["range"] = {p.low, p.high};
  return json;
}

}  // namespace palp
