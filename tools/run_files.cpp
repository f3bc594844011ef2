#include "tools/run_files.h"

#include <ctime>
#include <nlohmann/json.hpp>

#include "sim_server/probes/snapshot_points.h"
#include "sim_server/solver/rigid_motion.h"

namespace palp {

namespace {

void add(ProbeRow& row, const Eigen::Vector3d& v) { row.insert(row.end(), {v.x(), v.y(), v.z()}); }

std::vector<std::string> total_columns(const ProbeConfig& energy, const ProbeConfig& heat) {
  std::vector<std::string> columns = probe_columns(energy), warm = probe_columns(heat);
  columns.insert(columns.end(), warm.begin() + 1, warm.end());
  columns.insert(columns.end(),
                 {"px_N_s", "py_N_s", "pz_N_s", "Lx_N_m_s", "Ly_N_m_s", "Lz_N_m_s", "volume_m3", "penetration_m"});
  return columns;
}

ProbeConfig probe_of(Quantity quantity) {
  ProbeConfig probe;
  probe.quantity = quantity;
  return probe;
}

// Returns the time [s] that a share (0..1) of all does not exceed.
Json quantile(const FineHistogram& times, double share) {
  if (times.count() == 0) return nullptr;
  return 1e-6 * times.quantile_us(share);
}

std::int64_t nanoseconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return std::int64_t{1'000'000'000} * t.tv_sec + t.tv_nsec;
}

}  // namespace

ProxyFile::ProxyFile(const std::string& path)
    : file_(path, {"time_s",
                   "x_m",
                   "y_m",
                   "z_m",
                   "qx",
                   "qy",
                   "qz",
                   "qw",
                   "fx_N",
                   "fy_N",
                   "fz_N",
                   "tx_N_m",
                   "ty_N_m",
                   "tz_N_m",
                   "contact_fx_N",
                   "contact_fy_N",
                   "contact_fz_N",
                   "contact_tx_N_m",
                   "contact_ty_N_m",
                   "contact_tz_N_m"}) {}

void ProxyFile::write(double time, const ProxyOutput& proxy) {
  ProbeRow row{time};
  add(row, proxy.state.position);
  add(row, proxy.state.orientation.vec());
  row.push_back(proxy.state.orientation.w());
  for (const Eigen::Vector3d* v : {&proxy.force, &proxy.torque, &proxy.contact_force, &proxy.contact_torque})
    add(row, *v);
  file_.row(row);
}

TotalsFile::TotalsFile(const Scene& scene, const std::string& path)
    : scene_(scene),
      sampler_(scene),
      penetration_(scene),
      energy_(probe_of(Quantity::energy)),
      heat_(probe_of(Quantity::heat)),
      file_(path, total_columns(energy_, heat_)) {}

void TotalsFile::write(const Snapshot& snapshot, const StepOutput& output) {
  sampler_.load(&snapshot, output);
  ProbeRow row = sampler_.evaluate(energy_).front();
  const ProbeRow warm = sampler_.evaluate(heat_).front();
  row.insert(row.end(), warm.begin() + 1, warm.end());
  add_motion(snapshot, output, row);
  row.push_back(penetration_.deepest(snapshot, output));
  file_.row(row);
}

void TotalsFile::add_motion(const Snapshot& snapshot, const StepOutput& output, ProbeRow& row) const {
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  double volume = 0;
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Body& body = scene_.bodies[b];
    if (body.type == BodyKind::rigid) {
      const RigidMomenta whole = momenta_of(body, output.bodies[b].state);
      momentum += whole.momentum;
      angular += whole.angular;
    }
    if (body.type != BodyKind::fluid && body.type != BodyKind::elastic) continue;
    for (std::size_t i = body.first; i < body.first + body.count; ++i) {
      if (is_inactive(snapshot, i)) continue;
      const double mass = material_of(scene_, i).density * scene_.volume[i];
      const Eigen::Vector3d p = mass * Eigen::Map<const Eigen::Vector3f>(&snapshot.velocity[3 * i]).cast<double>();
      momentum += p;
      angular += place_of(snapshot, i).cross(p);
      if (body.type == BodyKind::fluid) volume += volume_of(scene_, snapshot, i);
    }
  }
  add(row, momentum);
  add(row, angular);
  row.push_back(volume);
}

StepTimes::Now StepTimes::now() { return {nanoseconds(CLOCK_MONOTONIC), nanoseconds(CLOCK_PROCESS_CPUTIME_ID)}; }

Json StepTimes::summary(double rate_hz) const {
  const double sum = 1e-9 * static_cast<double>(sum_ns_);
  const double reached = sum > 0 ? static_cast<double>(wall_.count()) / sum : 0;
  return {{"step_median_s", quantile(wall_, 0.5)},    {"step_p90_s", quantile(wall_, 0.9)},
          {"step_p99_s", quantile(wall_, 0.99)},      {"step_worst_s", quantile(wall_, 1)},
          {"step_cpu_median_s", quantile(cpu_, 0.5)}, {"reached_rate_hz", reached},
          {"real_time_factor", reached / rate_hz}};
}

}  // namespace palp
