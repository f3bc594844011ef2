#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "config/scene_reader.h"

namespace palp {

namespace {

const std::vector<std::string> kQuantities{"pressure", "density",  "velocity", "temperature", "wall_pressure", "front",
                                           "energy",   "extremes", "body",     "heat",        "pieces"};

// A point that cannot be read is put nowhere, so that no fault is added about where it lies.
const Eigen::Vector3d kNowhere = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

bool is_field(Quantity quantity) { return quantity <= Quantity::wall_pressure; }

// Reads the points of `point` or `line`, from first to last.
std::vector<Eigen::Vector3d> read_points(TomlTable& table) {
  std::vector<Eigen::Vector3d> points;
  if (table.has("point")) points.push_back(read_vector(table, "point", "m", kNowhere));
  if (!table.has("line")) return points;
  if (!points.empty()) table.fault("line", "both point and line are given, expected one of them");
  TomlTable line = table.table("line");
  const Eigen::Vector3d from = read_vector(line, "from", "m", kNowhere, Need::required);
  const Eigen::Vector3d to = read_vector(line, "to", "m", kNowhere, Need::required);
  const long long count = line.integer("count", 2, 10000, Need::required).value_or(2);
  points.clear();
  for (long long i = 0; i < count; ++i) {
    points.push_back(from + (to - from) * (static_cast<double>(i) / static_cast<double>(count - 1)));
  }
  return points;
}

// Adds a fault for each key that a probe of this quantity needs and lacks, or has and must not have.
void check_keys(TomlTable& table, const ProbeConfig& probe) {
  const std::string& quantity = kQuantities[static_cast<std::size_t>(probe.quantity)];
  const bool field = is_field(probe.quantity), front = probe.quantity == Quantity::front;
  if (field && !table.has("point") && !table.has("line")) {
    table.fault("", fmt::format("point is missing, expected a point or a line where to measure the {}", quantity));
  }
  const auto refuse = [&](const char* key, bool applies) {
    if (!applies && table.has(key)) table.fault(key, fmt::format("{} does not apply to a probe of {}", key, quantity));
  };
  refuse("point", field);
  refuse("line", field);
  refuse("body", !field);
  refuse("axis", front);
  refuse("side", front);
}

void check_body(TomlTable& table, const SceneConfig& scene, bool known_quantity, ProbeConfig& probe) {
  const bool required = known_quantity && probe.quantity == Quantity::body;
  const BodyConfig* body = read_body_name(table, scene, required ? Need::required : Need::optional);
  if (!body) return;
  probe.body = body->name;
  if (!known_quantity) return;
  const BodyKind type = body->type;
  if (required && type == BodyKind::fluid) {
    table.fault("body",
                fmt::format("body '{}' is a fluid, expected a rigid or static body, which has a pose", body->name));
  }
  const bool of_fluid = probe.quantity == Quantity::front || probe.quantity == Quantity::extremes;
  if (of_fluid && type != BodyKind::fluid && type != BodyKind::elastic) {
    table.fault("body", fmt::format("body '{}' does not deform, expected a fluid or elastic body", body->name));
  }
}

// Checks that the points of a probe lie inside the domain.
void check_place(TomlTable& table, const SceneConfig& scene, const ProbeConfig& probe) {
  const Eigen::Array3d low = scene.domain_min, high = scene.domain_max, slack = 1e-9 * (high - low);
  for (const Eigen::Vector3d& p : probe.points) {
    // an axis whose ends are the wrong way round has no inside
    if ((low < high && (p.array() + slack < low || p.array() - slack > high)).any()) {
      table.fault(
          table.has("line") ? "line" : "point",
          fmt::format("({:g}, {:g}, {:g}) is outside the domain, expected a point inside it", p.x(), p.y(), p.z()));
      break;
    }
  }
}

// Checks that the scene has the quantity that is to be measured.
void check_quantity(TomlTable& table, const SceneConfig& scene, const ProbeConfig& probe) {
  const bool of_heat =
      probe.quantity == Quantity::temperature || probe.quantity == Quantity::heat || probe.quantity == Quantity::pieces;
  if (of_heat && !has_temperature(scene)) {
    table.fault("quantity", fmt::format("quantity is \"{}\", but no body has a temperature",
                                        kQuantities[static_cast<std::size_t>(probe.quantity)]));
  }
}

}  // namespace

void read_probes(TomlTable& root, SceneConfig& scene) {
  for (TomlTable& table : root.tables("probe")) {
    ProbeConfig probe;
    probe.where = table.where();
    std::vector<std::string> taken;
    for (const ProbeConfig& other : scene.probes) taken.push_back(other.name);
    probe.name = read_name(table, "probe", taken, true);
    const auto quantity = table.choice("quantity", kQuantities, Need::required);
    probe.points = read_points(table);
    if (const auto axis = table.choice("axis", {"x", "y", "z"})) probe.axis = static_cast<int>(*axis);
    if (const auto side = table.choice("side", {"max", "min"})) probe.front_max = *side == 0;
    probe.rate_hz = table.number("rate_hz", positive("Hz")).value_or(std::min(probe.rate_hz, scene.rate_hz));
    if (probe.rate_hz > scene.rate_hz) {
      table.fault("rate_hz", fmt::format("rate_hz is {}, expected at most the scene's rate_hz, which is {}",
                                         probe.rate_hz, scene.rate_hz));
    }
    if (quantity) {
      probe.quantity = static_cast<Quantity>(*quantity);
      check_keys(table, probe);
      check_quantity(table, scene, probe);
    }
    check_body(table, scene, quantity.has_value(), probe);
    check_place(table, scene, probe);
    scene.probes.push_back(probe);
  }
}

}  // namespace palp
