#include "idl/validate.h"

#include <algorithm>
#include <cmath>

#include "idl/fields.h"
#include "idl/topics.h"

namespace palp {
namespace {

// Looks at every number of a message, by the lists of fields.h.
struct Finite {
  bool all = true;

  template <class T>
  void look(const T& value) {
    if constexpr (std::is_floating_point_v<T>) {
      all = all && std::isfinite(value);
    } else if constexpr (requires { fields_of(*this, value); }) {
      fields_of(*this, value);
    }
  }
  template <class T, std::size_t n>
  void look(const std::array<T, n>& values) {
    for (const T& value : values) look(value);
  }
  template <class T>
  void look(const std::vector<T>& values) {
    if constexpr (std::is_floating_point_v<T>) {
      int bad = 0;  // counted without a branch, several at a time
      for (const T value : values) bad |= !std::isfinite(value);
      all = all && bad == 0;
    } else if constexpr (!std::is_integral_v<T>) {
      for (const T& value : values) look(value);
    }
  }

// NOLINTBEGIN(bugprone-macro-parentheses): T is a type
#define PALP_FIELD(name) finite.look(m.name);
#define PALP_RENAMED(name, wire_name) finite.look(m.name);
#define PALP_DERIVED(wire_name, value)
#define PALP_LOOK(T)                                                                    \
  friend void fields_of([[maybe_unused]] Finite& finite, [[maybe_unused]] const T& m) { \
    PALP_FIELDS_OF_##T(PALP_FIELD, PALP_RENAMED, PALP_DERIVED)                          \
  }
  PALP_FOR_EACH_PART(PALP_LOOK)
  PALP_FOR_EACH_MESSAGE(PALP_LOOK)
#undef PALP_FIELD
#undef PALP_RENAMED
#undef PALP_DERIVED
#undef PALP_LOOK
  // NOLINTEND(bugprone-macro-parentheses)
};

// Each is_sound checks what a message must hold beyond finite numbers. Lengths come first: nothing of a message may be
// used as an index before.

bool is_name(const std::string& s) { return !s.empty() && s.size() <= kMaxName; }
bool is_text(const std::string& s) { return s.size() <= kMaxText; }

bool is_sound(const PoseD& p) {
  const auto& q = p.orientation;
  return std::abs(std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) - 1) <= kUnitTolerance;
}

bool is_sound(const CouplingGains& g) {
  return g.stiffness >= 0 && g.damping >= 0 && g.angular_stiffness >= 0 && g.angular_damping >= 0;
}

bool is_sound(const DeviceSample& m) { return m.device < kMaxDevices && is_sound(m.pose) && is_sound(m.gains); }

bool is_sound(const ProxySample& m) {
  const auto is_share = [](double blend) { return blend >= 0 && blend <= 1; };
  return m.device < kMaxDevices && m.sim_time >= 0 && is_sound(m.device_pose) && is_sound(m.proxy_pose) &&
         is_sound(m.gains) && is_share(m.blend[0]) && is_share(m.blend[1]);
}

bool is_sound(const ParticleChunk& m) {
  return m.particle_count <= kMaxParticles && static_cast<std::size_t>(m.field) < kScalarFields.size() &&
         well_placed(m) && m.sim_time >= 0;
}

bool is_sound(const Look& look) {
  const auto is_within = [](float value, float least, float most) { return value >= least && value <= most; };
  return is_within(look.roughness, 0, 1) && is_within(look.metallic, 0, 1) && is_within(look.grain, 0, 1) &&
         is_within(look.foam, 0, 1) && is_within(look.refractive_index, 1, kMostRefractiveIndex) &&
         is_within(look.scattering_length, 0, kMostScatteringLength) &&
         std::all_of(look.absorption_per_m.begin(), look.absorption_per_m.end(),
                     [&](float a) { return is_within(a, 0, kMostAbsorptionPerM); });
}

bool is_color(const std::array<float, 3>& color) {
  return std::all_of(color.begin(), color.end(), [](float c) { return c >= 0 && c <= 1; });
}

bool is_sound(const BodyDescription& body, std::uint32_t particle_count) {
  const std::size_t vertices = body.vertices.size() / 3;
  return body.name.size() <= kMaxName && body.kind <= BodyKind::elastic &&
         std::uint64_t{body.first} + body.count <= particle_count && body.density >= 0 && is_color(body.color) &&
         is_color(body.changed_color) && is_sound(body.look) && is_sound(body.changed_look) &&
         body.vertices.size() % 3 == 0 && body.vertices.size() <= kMaxMeshFloats && body.triangles.size() % 3 == 0 &&
         body.triangles.size() <= kMaxMeshIndices &&
         (body.rest.empty() || (body.kind == BodyKind::elastic && body.rest.size() == 3 * std::size_t{body.count})) &&
         std::all_of(body.triangles.begin(), body.triangles.end(), [&](std::uint32_t i) { return i < vertices; });
}

bool is_sound(const SceneDescription& m) {
  if (!is_text(m.name) || !is_text(m.method) || !is_text(m.numerics)) return false;
  if (m.particle_count > kMaxParticles || m.bodies.size() > kMaxBodies || m.proxies.size() > kMaxDevices) return false;
  if (!(m.spacing > 0 && m.support_radius > 0 && m.haptic_rate_hz > 0)) return false;
  for (int axis = 0; axis < 3; ++axis)
    if (m.bounds_min[axis] > m.bounds_max[axis]) return false;
  std::uint64_t count = 0;  // no particle is of two bodies
  for (const BodyDescription& body : m.bodies) {
    if (!is_sound(body, m.particle_count)) return false;
    count += body.count;
  }
  return count <= m.particle_count &&
         std::all_of(m.proxies.begin(), m.proxies.end(), [&](const ProxyDescription& proxy) {
           return proxy.device < kMaxDevices && proxy.body < m.bodies.size() && is_sound(proxy.pose);
         });
}

bool is_sound(const BodyPoses& m) {
  return m.sim_time >= 0 && m.body.size() == m.pose.size() && m.body.size() <= kMaxBodies &&
         std::all_of(m.body.begin(), m.body.end(), [](std::uint32_t i) { return i < kMaxBodies; }) &&
         std::all_of(m.pose.begin(), m.pose.end(), [](const PoseD& pose) { return is_sound(pose); });
}

bool is_sound(const Status& m) {
  return is_name(m.process) && is_text(m.state) && is_text(m.text) && m.metrics.size() <= kMaxMetrics &&
         std::all_of(m.metrics.begin(), m.metrics.end(), [](const Metric& metric) { return is_name(metric.name); });
}

bool is_sound(const Event& m) {
  return is_name(m.process) && m.severity <= Severity::fault && m.sim_time >= 0 && is_text(m.text);
}

bool is_sound(const Command& m) { return m.kind <= CommandKind::load_scene && is_text(m.name) && is_text(m.value); }

bool is_sound(const CommandReply& m) { return is_text(m.text); }

template <class T>
Fault judge(const T& m) {
  if (m.header.version != kProtocolVersion) return Fault::wrong_version;
  if (m.header.session == 0 || m.header.sequence == 0) return Fault::malformed;
  Finite finite;
  finite.look(m);
  if (!finite.all) return Fault::not_finite;
  return is_sound(m) ? Fault::none : Fault::malformed;
}

}  // namespace

#define PALP_VALIDATE(T) \
  Fault validate(const T& m) { return judge(m); }
PALP_FOR_EACH_MESSAGE(PALP_VALIDATE)
#undef PALP_VALIDATE

Fault validate(const ParticleFrame& f) {
  Finite finite;
  finite.look(f.sim_time);
  finite.look(f.positions);
  finite.look(f.scalars);
  if (!finite.all) return Fault::not_finite;
  const std::size_t n = f.positions.size() / 3;
  const bool sound = n <= kMaxParticles && f.positions.size() == 3 * n &&
                     static_cast<std::size_t>(f.field) < kScalarFields.size() &&
                     f.scalars.size() == (f.field == ScalarField::none ? 0 : n) &&
                     (f.solid.empty() || f.solid.size() == n) && f.sim_time >= 0;
  return sound ? Fault::none : Fault::malformed;
}

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
