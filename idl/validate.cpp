#include "idl/validate.h"

#include <algorithm>
#include <cmath>

#include "idl/particle_frame.h"

namespace palp {
namespace {

// Collects what is found: the first fault stays.
class Check {
 public:
  explicit Check(const Header& header) {
    if (header.version != kProtocolVersion) fault_ = Fault::wrong_version;
    sound(header.session != 0 && header.sequence != 0);
  }
  Fault fault() const { return fault_; }

  Check& sound(bool condition) {
    if (fault_ == Fault::none && !condition) fault_ = Fault::malformed;
    return *this;
  }
  Check& finite(double x) {
    if (fault_ == Fault::none && !std::isfinite(x)) fault_ = Fault::not_finite;
    return *this;
  }
  template <class Values>
  Check& all_finite(const Values& values) {
    if (fault_ != Fault::none) return *this;
    for (const auto x : values) {
      if (!std::isfinite(x)) fault_ = Fault::not_finite;
    }
    return *this;
  }
  Check& at_least(double x, double low) { return finite(x).sound(x >= low); }
  Check& above(double x, double low) { return finite(x).sound(x > low); }

  Check& pose(const PoseD& p) {
    all_finite(p.position).all_finite(p.orientation);
    const auto& q = p.orientation;
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return sound(std::abs(length - 1) <= kQuaternionTolerance);
  }
  Check& twist(const TwistD& t) { return all_finite(t.linear).all_finite(t.angular); }
  Check& gains(const CouplingGains& g) {
    return at_least(g.stiffness, 0)
        .at_least(g.damping, 0)
        .at_least(g.angular_stiffness, 0)
        .at_least(g.angular_damping, 0);
  }
  Check& name(const std::string& s) { return sound(!s.empty() && s.size() <= kMaxName); }
  Check& text(const std::string& s) { return sound(s.size() <= kMaxText); }

 private:
  Fault fault_ = Fault::none;
};

void check_body(const BodyDescription& body, std::uint32_t particle_count, Check& check) {
  check.sound(body.name.size() <= kMaxName && body.kind <= BodyKind::elastic);
  check.sound(std::uint64_t{body.first} + body.count <= particle_count);
  check.at_least(body.density, 0).all_finite(body.color);
  check.sound(std::all_of(body.color.begin(), body.color.end(), [](float c) { return c >= 0 && c <= 1; }));
  check.sound(body.vertices.size() % 3 == 0 && body.vertices.size() <= kMaxMeshFloats).all_finite(body.vertices);
  check.sound(body.triangles.size() % 3 == 0 && body.triangles.size() <= kMaxMeshIndices);
  const std::size_t vertices = body.vertices.size() / 3;
  check.sound(std::all_of(body.triangles.begin(), body.triangles.end(), [&](std::uint32_t i) { return i < vertices; }));
}

}  // namespace

Fault validate(const DeviceSample& m) {
  return Check(m.header).sound(m.device < kMaxDevices).pose(m.pose).twist(m.twist).gains(m.gains).fault();
}

Fault validate(const ProxySample& m) {
  Check check(m.header);
  check.sound(m.device < kMaxDevices).at_least(m.sim_time, 0);
  check.pose(m.device_pose).twist(m.device_twist).pose(m.proxy_pose).twist(m.proxy_twist);
  check.all_finite(m.wrench.force).all_finite(m.wrench.torque).gains(m.gains).all_finite(m.energy);
  for (const double blend : m.blend) check.finite(blend).sound(blend >= 0 && blend <= 1);
  return check.fault();
}

Fault validate(const ParticleChunk& m) {
  Check check(m.header);
  check.sound(m.particle_count >= 1 && m.particle_count <= kMaxParticles && m.field <= ScalarField::temperature);
  return check.sound(well_placed(m)).at_least(m.sim_time, 0).all_finite(m.positions).all_finite(m.scalars).fault();
}

Fault validate(const SceneDescription& m) {
  Check check(m.header);
  check.text(m.name).text(m.method).text(m.numerics);
  check.sound(m.particle_count <= kMaxParticles && m.bodies.size() <= kMaxBodies && m.proxies.size() <= kMaxDevices);
  check.above(m.spacing, 0).above(m.support_radius, 0).above(m.haptic_rate_hz, 0);
  check.all_finite(m.bounds_min).all_finite(m.bounds_max).all_finite(m.gravity);
  for (int axis = 0; axis < 3; ++axis) check.sound(m.bounds_min[axis] <= m.bounds_max[axis]);
  if (check.fault() != Fault::none) return check.fault();
  std::uint64_t count = 0;  // no particle is of two bodies
  for (const BodyDescription& body : m.bodies) {
    check_body(body, m.particle_count, check);
    count += body.count;
  }
  check.sound(count <= m.particle_count);
  for (const ProxyDescription& proxy : m.proxies) {
    check.sound(proxy.device < kMaxDevices && proxy.body < m.bodies.size()).pose(proxy.pose);
  }
  return check.fault();
}

Fault validate(const BodyPoses& m) {
  Check check(m.header);
  check.at_least(m.sim_time, 0).sound(m.body.size() == m.pose.size() && m.body.size() <= kMaxBodies);
  check.sound(std::all_of(m.body.begin(), m.body.end(), [](std::uint32_t i) { return i < kMaxBodies; }));
  if (check.fault() != Fault::none) return check.fault();
  for (const PoseD& pose : m.pose) check.pose(pose);
  return check.fault();
}

Fault validate(const Status& m) {
  Check check(m.header);
  check.name(m.process).text(m.state).text(m.text).sound(m.metrics.size() <= kMaxMetrics);
  if (check.fault() != Fault::none) return check.fault();
  for (const Metric& metric : m.metrics) check.name(metric.name).finite(metric.value);
  return check.fault();
}

Fault validate(const Event& m) {
  return Check(m.header)
      .name(m.process)
      .sound(m.severity <= Severity::fault)
      .at_least(m.sim_time, 0)
      .text(m.text)
      .fault();
}

Fault validate(const Command& m) {
  return Check(m.header).sound(m.kind <= CommandKind::set_parameter).text(m.name).text(m.value).fault();
}

Fault validate(const CommandReply& m) { return Check(m.header).text(m.text).fault(); }

void count(Fault fault, const Header& header, DropCounts& drops) {
  switch (fault) {
    case Fault::none:
      break;
    case Fault::wrong_version:
      ++drops.wrong_version;
      drops.other_version = header.version;
      break;
    case Fault::not_finite:
      ++drops.not_finite;
      break;
    case Fault::malformed:
      ++drops.malformed;
      break;
  }
}

std::string wrong_version_sentence(const char* topic, const DropCounts& drops) {
  if (drops.wrong_version == 0) return "";
  return "a peer speaks protocol version " + std::to_string(drops.other_version) + " on " + topic +
         " and this process speaks version " + std::to_string(kProtocolVersion) + ": " +
         std::to_string(drops.wrong_version) + " of its samples were refused; run the same release of palp everywhere";
}

void SequenceGaps::arrived(const Header& header, std::uint64_t key) {
  ++clock_;
  for (Entry& e : entries_) {
    if (e.session != header.session || e.key != key) continue;
    e.used = clock_;
    if (header.sequence <= e.last) return;
    lost_ += header.sequence - e.last - 1;
    e.last = header.sequence;
    return;
  }
  const auto oldest = std::min_element(entries_.begin(), entries_.end(),
                                       [](const Entry& a, const Entry& b) { return a.used < b.used; });
  *oldest = {header.session, key, header.sequence, clock_};
}

}  // namespace palp
