#include "sim_server/probes/probes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "sim_server/physics/smoothing.h"
#include "sim_server/scene/scene_heat.h"
#include "sim_server/solver/rigid_motion.h"

namespace palp {

namespace {

constexpr double kReachOverSpacing = 2;

// The share of the kernel below which a place counts as within solids, where no fluid reaches it.
constexpr double kLeastRoom = 0.05;

constexpr auto kKernel = WendlandC2Of<double>::unit();  // the division by the sum of weights removes its scale

Eigen::Vector3d vector_at(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

std::optional<double> finite(double value) {
  return std::isfinite(value) ? std::optional<double>(value) : std::nullopt;
}

void add(ProbeRow& row, const Eigen::Vector3d& v) {
  for (int a = 0; a < 3; ++a) row.push_back(finite(v[a]));
}

// Two bodies in contact are at the mean of their temperatures with these weights, so a mean across a contact takes
// them, too. Where nothing conducts they are all alike.
double effusivity(const MaterialConfig& m) { return std::sqrt(m.conductivity * m.density * m.heat_capacity) + 1e-9; }

bool is_line(const ProbeConfig& probe) { return probe.points.size() > 1; }

}  // namespace

std::vector<std::string> probe_columns(const ProbeConfig& probe) {
  std::vector<std::string> columns{"time_s"};
  const auto more = [&](const std::vector<std::string>& names) {
    columns.insert(columns.end(), names.begin(), names.end());
  };
  if (is_line(probe)) more({"x_m", "y_m", "z_m"});
  switch (probe.quantity) {
    case Quantity::pressure:
    case Quantity::wall_pressure:
      more({"pressure_Pa"});
      break;
    case Quantity::density:
      more({"density_kg_m3"});
      break;
    case Quantity::velocity:
      more({"vx_m_s", "vy_m_s", "vz_m_s"});
      break;
    case Quantity::temperature:
      more({"temperature_K"});
      break;
    case Quantity::front:
      more({std::string("front_") + "xyz"[probe.axis] + "_m"});
      break;
    case Quantity::energy:
      more({"kinetic_J", "potential_J", "total_J", "stored_J"});
      break;
    case Quantity::extremes:
      more({"max_speed_m_s", "min_pressure_Pa", "max_pressure_Pa", "min_density_kg_m3", "max_density_kg_m3"});
      break;
    case Quantity::heat:
      more({"heat_J", "min_temperature_K", "mean_temperature_K", "max_temperature_K", "liquid_fraction"});
      break;
    case Quantity::pieces:
      more({"pieces", "largest_kg"});
      break;
    case Quantity::body:
      more({"x_m", "y_m", "z_m", "qx", "qy", "qz", "qw", "vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s",
            "wz_rad_s", "fx_N", "fy_N", "fz_N", "tx_N_m", "ty_N_m", "tz_N_m"});
      break;
  }
  return columns;
}

bool needs_snapshot(const ProbeConfig& probe) { return probe.quantity != Quantity::body; }

ProbeSampler::ProbeSampler(const Scene& scene) : scene_(scene), pressure_(scene) {}

void ProbeSampler::load(const Snapshot* snapshot, const StepOutput& output) {
  snapshot_ = snapshot;
  pressure_.load(snapshot);
  output_ = &output;
  fluids_.reset();
  all_.reset();
  within_support_.reset();
}

std::vector<ProbeRow> ProbeSampler::evaluate(const ProbeConfig& probe) const {
  std::vector<ProbeRow> rows;
  switch (probe.quantity) {
    case Quantity::front:
      rows.push_back(front(probe));
      break;
    case Quantity::energy:
      rows.push_back(energy(probe));
      break;
    case Quantity::extremes:
      rows.push_back(extremes(probe));
      break;
    case Quantity::body:
      rows.push_back(body(probe));
      break;
    case Quantity::heat:
      rows.push_back(heat(probe));
      break;
    case Quantity::pieces:
      rows.push_back(pieces(probe));
      break;
    default:
      for (const Eigen::Vector3d& point : probe.points) {
        if (probe.quantity == Quantity::wall_pressure)
          rows.push_back({on_wall(point)});
        else
          rows.push_back(at_point(probe, point));
        if (is_line(probe)) rows.back().insert(rows.back().begin(), {point.x(), point.y(), point.z()});
      }
  }
  for (ProbeRow& row : rows) row.insert(row.begin(), output_->time);
  return rows;
}

// Returns whether the particles of a body move each on its own.
static bool is_deformable(const Body& body) { return body.type == BodyKind::fluid || body.type == BodyKind::elastic; }

ProbeRow ProbeSampler::at_point(const ProbeConfig& probe, const Eigen::Vector3d& point) const {
  const double reach = kReachOverSpacing * scene_.spacing;
  // a temperature goes on from the fluid into the solid
  const bool solids = probe.quantity == Quantity::temperature;
  std::optional<SnapshotPoints>& points = solids ? all_ : fluids_;
  if (!points) points.emplace(scene_, *snapshot_, reach, solids);
  double weights = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  points->near(point, [&](std::uint32_t i, double r) {
    const MaterialConfig& material = material_of(scene_, i);
    double w = volume_of(scene_, *snapshot_, i) * kKernel.W(r / reach);
    if (probe.quantity == Quantity::temperature) w *= effusivity(material);
    if (!(w > 0)) return;
    weights += w;
    switch (probe.quantity) {
      case Quantity::pressure:
        sum[0] += w * pressure_.of(i);
        break;
      case Quantity::density:
        sum[0] += w * snapshot_->density[i];
        break;
      case Quantity::temperature:
        sum[0] += snapshot_->temperature.empty() ? NAN : w * snapshot_->temperature[i];
        break;
      default:
        sum += w * vector_at(snapshot_->velocity, i);
    }
  });
  if (solids) add_solids(point, reach, weights, sum[0]);
  const bool vector = probe.quantity == Quantity::velocity;
  if (weights <= 0) return ProbeRow(vector ? 3 : 1);
  if (!vector) return {finite(sum[0] / weights)};
  ProbeRow row;
  add(row, sum / weights);
  return row;
}

void ProbeSampler::add_solids(const Eigen::Vector3d& point, double reach, double& weights, double& sum) const {
  const auto bounds = [&](const Body& body) { return bounds_heat(scene_, body); };
  if (std::none_of(scene_.bodies.begin(), scene_.bodies.end(), bounds)) return;
  const auto state_of = [&](std::size_t body) { return body_state(body).state; };
  solids().that_bound_heat(point, reach, state_of, [&](std::size_t b, double share) {
    const Body& body = scene_.bodies[b];
    const double w = reach * reach * reach * share * effusivity(scene_.config.materials[body.material]);
    weights += w;
    sum += w * *body.temperature;
  });
}

std::optional<double> ProbeSampler::on_wall(const Eigen::Vector3d& point) const {
  const double support = snapshot_->support;
  const auto state_of = [&](std::size_t body) { return body_state(body).state; };
  if (!within_support_) within_support_.emplace(scene_, *snapshot_, support, true);
  const auto kernel = FluidKernelOf<double>::with_support(support, scene_.spacing);
  double sum = 0, room = solids().room(point, support, state_of);
  within_support_->near(point, [&](std::uint32_t i, double r) {
    const double w = volume_of(scene_, *snapshot_, i) * kernel.W(r);
    const Body& body = scene_.bodies[scene_.body[i]];
    if (body.type == BodyKind::fluid)
      sum += w * pressure_.of(i);
    else if (!solids().acts_by_geometry(body))
      room -= w;
  });
  return room < kLeastRoom ? std::nullopt : finite(sum / room);
}

const SolidsAround& ProbeSampler::solids() const {
  if (!solids_) solids_.emplace(scene_);
  return *solids_;
}

bool ProbeSampler::counts(const ProbeConfig& probe, std::size_t body) const {
  return probe.body.empty() || scene_.bodies[body].name == probe.body;
}

ProbeRow ProbeSampler::front(const ProbeConfig& probe) const {
  const double sign = probe.front_max ? 1 : -1;
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Body& body = scene_.bodies[b];
    if (!is_deformable(body) || !counts(probe, b)) continue;
    for (std::size_t i = body.first; i < body.first + body.count; ++i) {
      if (is_inactive(*snapshot_, i)) continue;
      const double value = sign * place_of(*snapshot_, i)[probe.axis];
      if (value > best) best = value;
    }
  }
  return {finite(sign * best)};
}

ProbeRow ProbeSampler::energy(const ProbeConfig& probe) const {
  double kinetic = 0, potential = 0, stored = 0;
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Body& body = scene_.bodies[b];
    if (body.type == BodyKind::fixed || !counts(probe, b)) continue;
    if (is_deformable(body)) {
      const double density = scene_.config.materials[body.material].density;
      for (std::size_t i = body.first; i < body.first + body.count; ++i) {
        if (is_inactive(*snapshot_, i)) continue;
        const double mass = density * scene_.volume[i];
        kinetic += mass / 2 * vector_at(snapshot_->velocity, i).squaredNorm();
        potential -= mass * scene_.config.gravity.dot(place_of(*snapshot_, i));
        if (!snapshot_->stored.empty()) stored += snapshot_->stored[i];
      }
      continue;
    }
    const RigidMomenta whole = momenta_of(body, body_state(b).state);
    kinetic += whole.kinetic;
    potential -= body.mass * scene_.config.gravity.dot(whole.center);
  }
  return {finite(kinetic), finite(potential), finite(kinetic + potential + stored), finite(stored)};
}

ProbeRow ProbeSampler::extremes(const ProbeConfig& probe) const {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  double speed = -kInf, pressure[2] = {kInf, -kInf}, density[2] = {kInf, -kInf};
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Body& body = scene_.bodies[b];
    if (!is_deformable(body) || !counts(probe, b)) continue;
    for (std::size_t i = body.first; i < body.first + body.count; ++i) {
      if (is_inactive(*snapshot_, i)) continue;
      speed = std::max(speed, vector_at(snapshot_->velocity, i).norm());
      if (body.type != BodyKind::fluid) continue;
      const double p = pressure_.of(static_cast<std::uint32_t>(i));
      pressure[0] = std::min(pressure[0], p);
      pressure[1] = std::max(pressure[1], p);
      density[0] = std::min<double>(density[0], snapshot_->density[i]);
      density[1] = std::max<double>(density[1], snapshot_->density[i]);
    }
  }
  return {finite(speed), finite(pressure[0]), finite(pressure[1]), finite(density[0]), finite(density[1])};
}

// Means are weighted by mass; the liquid fraction is that of what can melt. A solid that bounds heat is as warm as at
// the start, whatever flows into it, and takes up none.
ProbeRow ProbeSampler::heat(const ProbeConfig& probe) const {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  double taken_up = 0, low = kInf, high = -kInf, mean = 0, mass = 0, liquid = 0, melting = 0;
  const bool flows = !snapshot_->heat.empty(), warm = has_temperatures(scene_) || !snapshot_->temperature.empty();
  for (std::size_t b = 0; b < scene_.bodies.size() && warm; ++b) {
    const Body& body = scene_.bodies[b];
    if (!counts(probe, b)) continue;
    const MaterialConfig& material = scene_.config.materials[body.material];
    const auto add = [&](double m, double T, double liquid_share) {
      mass += m;
      mean += m * T;
      low = std::min(low, T);
      high = std::max(high, T);
      if (!flows || !material.melting_temperature) return;
      melting += m;
      liquid += m * liquid_share;
    };
    if (bounds_heat(scene_, body)) {
      add(body.mass, *body.temperature, *body.temperature > material.melting_temperature.value_or(0) ? 1 : 0);
      continue;
    }
    for (std::size_t i = body.first; i < body.first + body.count; ++i) {
      add(material.density * scene_.volume[i], snapshot_->temperature[i], flows ? snapshot_->liquid[i] : 0);
      if (flows) taken_up += snapshot_->heat[i];
    }
  }
  return {finite(flows ? taken_up : NAN), finite(low), finite(mean / mass), finite(high), finite(liquid / melting)};
}

// Returns, for matter that changes state, how many pieces it is solid in, and the mass of the largest.
ProbeRow ProbeSampler::pieces(const ProbeConfig& probe) const {
  std::map<std::uint32_t, double> mass;
  double largest = 0;
  for (std::size_t i = 0; i < snapshot_->body_id.size(); ++i) {
    const std::uint32_t b = scene_.body[i], id = snapshot_->body_id[i];
    if (!counts(probe, b) || id == b) continue;
    double& sum = mass[id];
    sum += scene_.config.materials[scene_.bodies[b].material].density * scene_.volume[i];
    largest = std::max(largest, sum);
  }
  return {finite(static_cast<double>(mass.size())), finite(largest)};
}

BodyOutput ProbeSampler::body_state(std::size_t index) const {
  if (index < output_->bodies.size()) return output_->bodies[index];
  const Body& body = scene_.bodies[index];
  BodyOutput initial;
  initial.state.position = body.position;
  initial.state.orientation = body.orientation;
  initial.state.angular = body.angular_velocity;
  initial.state.linear = body.velocity - body.angular_velocity.cross(body.orientation * body.center);
  return initial;
}

ProbeRow ProbeSampler::body(const ProbeConfig& probe) const {
  const auto found = std::find_if(scene_.bodies.begin(), scene_.bodies.end(),
                                  [&](const Body& item) { return item.name == probe.body; });
  const auto index = static_cast<std::size_t>(found - scene_.bodies.begin());
  const BodyOutput out = body_state(index);
  ProbeRow row;
  add(row, out.state.position);
  add(row, out.state.orientation.vec());
  row.push_back(finite(out.state.orientation.w()));
  add(row, out.state.linear);
  add(row, out.state.angular);
  if (index < output_->bodies.size()) {
    add(row, out.force);
    add(row, out.torque);
  } else {
    row.resize(row.size() + 6);  // no force before the first step
  }
  return row;
}

bool rate_due(std::uint64_t step, double rate_hz, double base_rate_hz) {
  if (!(rate_hz > 0)) return false;
  if (step == 0) return true;
  const double per_step = rate_hz / base_rate_hz, slack = 1e-9;
  return std::floor(static_cast<double>(step) * per_step + slack) >
         std::floor(static_cast<double>(step - 1) * per_step + slack);
}

ProbeRecorder::ProbeRecorder(const Scene& scene, const std::string& folder) : scene_(scene), sampler_(scene) {
  make_folder(folder);
  for (const ProbeConfig& probe : scene.config.probes)
    files_.emplace_back(folder + "/" + probe.name + ".csv", probe_columns(probe));
}

bool ProbeRecorder::due(const ProbeConfig& probe, std::uint64_t step) const {
  return rate_due(step, probe.rate_hz, scene_.config.rate_hz);
}

bool ProbeRecorder::due(std::uint64_t step) const {
  return std::any_of(scene_.config.probes.begin(), scene_.config.probes.end(),
                     [&](const ProbeConfig& probe) { return due(probe, step); });
}

bool ProbeRecorder::due_with_snapshot(std::uint64_t step) const {
  return std::any_of(scene_.config.probes.begin(), scene_.config.probes.end(),
                     [&](const ProbeConfig& probe) { return needs_snapshot(probe) && due(probe, step); });
}

void ProbeRecorder::record(const Snapshot* snapshot, const StepOutput& output) {
  sampler_.load(snapshot, output);
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const ProbeConfig& probe = scene_.config.probes[i];
    if (!due(probe, output.step)) continue;
    for (const ProbeRow& row : sampler_.evaluate(probe)) files_[i].row(row);
  }
}

void ProbeRecorder::close() {
  for (CsvFile& file : files_) file.close();
}

}  // namespace palp
