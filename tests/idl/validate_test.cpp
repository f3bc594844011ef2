#include "idl/validate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/support/valid_messages.h"

namespace palp::test::validate_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// Every spoilt copy of a sound message must be found out, and for the right reason.
template <class T>
void expect_fault(Fault fault, const std::function<void(T&)>& spoil, int line) {
  T m = sound<T>();
  ASSERT_EQ(validate(m), Fault::none);
  spoil(m);
  EXPECT_EQ(validate(m), fault) << "of the change in line " << line;
}
#define SPOIL(T, fault, ...) \
  expect_fault<T>(           \
      Fault::fault, [&](T& m) { __VA_ARGS__; }, __LINE__)

TEST(Validate, LooksAtTheHeaderOfEveryMessage) {
#define PALP_CHECK(T)                                               \
  SPOIL(T, wrong_version, m.header.version = kProtocolVersion + 1); \
  SPOIL(T, wrong_version, m.header = {}; m.header.version = 0);     \
  SPOIL(T, malformed, m.header.session = 0);                        \
  SPOIL(T, malformed, m.header.sequence = 0);
  PALP_FOR_EACH_MESSAGE(PALP_CHECK)
#undef PALP_CHECK
}

TEST(Validate, DeviceSample) {
  SPOIL(DeviceSample, malformed, m.device = kMaxDevices);
  SPOIL(DeviceSample, not_finite, m.pose.position[1] = kNan);
  SPOIL(DeviceSample, not_finite, m.pose.orientation[3] = kInf);
  SPOIL(DeviceSample, malformed, m.pose.orientation = {});
  SPOIL(DeviceSample, malformed, m.pose.orientation[3] *= 1.01);
  SPOIL(DeviceSample, not_finite, m.twist.linear[0] = -kInf);
  SPOIL(DeviceSample, not_finite, m.twist.angular[2] = kNan);
  SPOIL(DeviceSample, not_finite, m.gains.angular_damping = kNan);
  SPOIL(DeviceSample, malformed, m.gains.stiffness = -1);
  SPOIL(DeviceSample, none, m.pose.orientation[3] *= 1.0005);
}

TEST(Validate, ProxySample) {
  SPOIL(ProxySample, malformed, m.device = kMaxDevices);
  SPOIL(ProxySample, malformed, m.sim_time = -1);
  SPOIL(ProxySample, not_finite, m.device_pose.position[0] = kNan);
  SPOIL(ProxySample, malformed, m.device_pose.orientation = {0, 0, 0, 2});
  SPOIL(ProxySample, not_finite, m.device_twist.angular[0] = kNan);
  SPOIL(ProxySample, malformed, m.proxy_pose.orientation = {});
  SPOIL(ProxySample, not_finite, m.proxy_twist.linear[2] = kInf);
  SPOIL(ProxySample, not_finite, m.wrench.force[0] = kNan);
  SPOIL(ProxySample, not_finite, m.wrench.torque[0] = kNan);
  SPOIL(ProxySample, malformed, m.gains.damping = -1e-9);
  SPOIL(ProxySample, malformed, m.blend[0] = 1.5);
  SPOIL(ProxySample, not_finite, m.blend[1] = kNan);
  SPOIL(ProxySample, not_finite, m.energy[1] = kInf);
}

TEST(Validate, ParticleChunk) {
  SPOIL(ParticleChunk, malformed, m.chunk = m.chunk_count);
  SPOIL(ParticleChunk, malformed, m.chunk_count = 0);
  SPOIL(ParticleChunk, malformed, m.particle_count = 0);
  SPOIL(ParticleChunk, malformed, m.particle_count = kMaxParticles + 1);
  SPOIL(ParticleChunk, malformed, m.first = 1);
  SPOIL(ParticleChunk, malformed, m.positions.push_back(0));
  SPOIL(ParticleChunk, malformed, m.positions.clear());
  SPOIL(ParticleChunk, malformed, m.scalars.pop_back());
  SPOIL(ParticleChunk, malformed, m.field = static_cast<ScalarField>(kScalarFields.size()));
  SPOIL(ParticleChunk, malformed, m.field = ScalarField::none);
  for (std::size_t field = 1; field < kScalarFields.size(); ++field) {
    SPOIL(ParticleChunk, none, m.field = static_cast<ScalarField>(field));
  }
  SPOIL(ParticleChunk, not_finite, m.positions.back() = std::nanf(""));
  SPOIL(ParticleChunk, not_finite, m.scalars.front() = static_cast<float>(kInf));
  SPOIL(ParticleChunk, not_finite, m.sim_time = kNan);
}

TEST(Validate, ParticleFrame) {
  ParticleFrame sound;
  sound.sim_time = 0.5;
  sound.field = ScalarField::speed;
  sound.positions = {1, 2, 3, 4, 5, 6};
  sound.scalars = {7, 8};
  sound.solid = {0, 255};
  const auto fault_with = [&](auto spoil) {
    ParticleFrame frame = sound;
    spoil(frame);
    return validate(frame);
  };
  EXPECT_EQ(validate(sound), Fault::none);
  EXPECT_EQ(fault_with([](ParticleFrame& f) { f.positions.pop_back(); }), Fault::malformed);
  EXPECT_EQ(fault_with([](ParticleFrame& f) { f.scalars.pop_back(); }), Fault::malformed);
  EXPECT_EQ(fault_with([](ParticleFrame& f) { f.solid.pop_back(); }), Fault::malformed);
  EXPECT_EQ(fault_with([](ParticleFrame& f) { f.solid.clear(); }), Fault::none);
  EXPECT_EQ(fault_with([](ParticleFrame& f) { f.field = ScalarField::none; }), Fault::malformed);
  EXPECT_EQ(fault_with([](ParticleFrame& f) { f.field = static_cast<ScalarField>(kScalarFields.size()); }),
            Fault::malformed);
  EXPECT_EQ(fault_with([](ParticleFrame& f) { f.sim_time = -1; }), Fault::malformed);
  EXPECT_EQ(fault_with([](ParticleFrame& f) { f.sim_time = kNan; }), Fault::not_finite);
  EXPECT_EQ(fault_with([](ParticleFrame& f) { f.positions.back() = std::nanf(""); }), Fault::not_finite);
  EXPECT_EQ(fault_with([](ParticleFrame& f) { f.scalars.front() = static_cast<float>(kInf); }), Fault::not_finite);
}

TEST(Validate, SceneDescription) {
  SPOIL(SceneDescription, malformed, m.name = std::string(kMaxText + 1, 'x'));
  SPOIL(SceneDescription, malformed, m.particle_count = kMaxParticles + 1);
  SPOIL(SceneDescription, malformed, m.bodies.resize(1000, m.bodies[0]));  // all of the same particles
  SPOIL(SceneDescription, malformed, m.spacing = 0);
  SPOIL(SceneDescription, not_finite, m.support_radius = kNan);
  SPOIL(SceneDescription, malformed, m.haptic_rate_hz = -1);
  SPOIL(SceneDescription, not_finite, m.bounds_max[2] = kInf);
  SPOIL(SceneDescription, malformed, m.bounds_min[0] = m.bounds_max[0] + 1);
  SPOIL(SceneDescription, not_finite, m.gravity[2] = kNan);
  SPOIL(SceneDescription, malformed, m.bodies[0].kind = static_cast<BodyKind>(4));
  SPOIL(SceneDescription, malformed, m.bodies[0].count = m.particle_count + 1);
  SPOIL(SceneDescription, malformed, m.bodies[0].first = 0xffffffff);
  SPOIL(SceneDescription, malformed, m.bodies[0].density = -1);
  SPOIL(SceneDescription, malformed, m.bodies[0].color[1] = 1.5f);
  SPOIL(SceneDescription, not_finite, m.bodies[0].color[1] = std::nanf(""));
  SPOIL(SceneDescription, malformed, m.bodies[0].look.roughness = 1.5f);
  SPOIL(SceneDescription, malformed, m.bodies[0].look.metallic = -0.1f);
  SPOIL(SceneDescription, malformed, m.bodies[0].look.refractive_index = 0.9f);
  SPOIL(SceneDescription, malformed, m.bodies[0].look.absorption_per_m[2] = -1);
  SPOIL(SceneDescription, malformed, m.bodies[0].look.absorption_per_m[0] = 2 * kMostAbsorptionPerM);
  SPOIL(SceneDescription, malformed, m.bodies[0].look.scattering_length = 2 * kMostScatteringLength);
  SPOIL(SceneDescription, malformed, m.bodies[0].look.grain = 2);
  SPOIL(SceneDescription, malformed, m.bodies[0].look.foam = -0.5f);
  SPOIL(SceneDescription, not_finite, m.bodies[0].look.roughness = std::nanf(""));
  SPOIL(SceneDescription, not_finite, m.bodies[0].look.absorption_per_m[1] = std::nanf(""));
  SPOIL(SceneDescription, malformed, m.bodies[1].vertices.pop_back());
  SPOIL(SceneDescription, not_finite, m.bodies[1].vertices[4] = std::nanf(""));
  SPOIL(SceneDescription, malformed, m.bodies[1].triangles[2] = 3);
  SPOIL(SceneDescription, malformed, m.bodies[1].triangles.push_back(0));
  SPOIL(SceneDescription, malformed, m.bodies[2].rest.pop_back());
  SPOIL(SceneDescription, malformed, m.bodies[2].kind = BodyKind::rigid);
  SPOIL(SceneDescription, malformed, m.proxies[0].body = 3);
  SPOIL(SceneDescription, malformed, m.proxies[0].device = kMaxDevices);
  SPOIL(SceneDescription, malformed, m.proxies[0].pose.orientation = {});
  SPOIL(SceneDescription, malformed, m.proxies.resize(kMaxDevices + 1, m.proxies[0]));
}

TEST(Validate, BodyPoses) {
  SPOIL(BodyPoses, malformed, m.body.pop_back());
  SPOIL(BodyPoses, malformed, m.body[0] = kMaxBodies);
  SPOIL(BodyPoses, malformed, m.pose[1].orientation = {});
  SPOIL(BodyPoses, not_finite, m.pose[1].position[0] = kNan);
  SPOIL(BodyPoses, not_finite, m.sim_time = kNan);
}

TEST(Validate, Texts) {
  SPOIL(Status, malformed, m.process.clear());
  SPOIL(Status, malformed, m.process = std::string(kMaxName + 1, 'x'));
  SPOIL(Status, malformed, m.metrics.resize(kMaxMetrics + 1, m.metrics[0]));
  SPOIL(Status, not_finite, m.metrics[0].value = kNan);
  SPOIL(Status, malformed, m.metrics[0].name.clear());
  SPOIL(Event, malformed, m.severity = static_cast<Severity>(3));
  SPOIL(Event, not_finite, m.sim_time = kNan);
  SPOIL(Event, malformed, m.text = std::string(kMaxText + 1, 'x'));
  SPOIL(Command, malformed, m.kind = static_cast<CommandKind>(8));
  SPOIL(Command, malformed, m.value = std::string(kMaxText + 1, 'x'));
  SPOIL(CommandReply, malformed, m.text = std::string(kMaxText + 1, 'x'));
}

TEST(Drops, NameTheOtherVersionInOneSentence) {
  DropCounts drops;
  EXPECT_EQ(wrong_version_sentence("palp/device", drops), "");
  Header other;
  other.version = 7;
  count(Fault::wrong_version, other, drops);
  const std::string text = wrong_version_sentence("palp/device", drops);
  EXPECT_NE(text.find("version 7"), std::string::npos);
  EXPECT_NE(text.find("palp/device"), std::string::npos);
}

TEST(SequenceGaps, CountsEachSessionAndKeyByItself) {
  SequenceGaps gaps;
  const auto arrive = [&](std::uint64_t session, std::uint64_t key, std::uint64_t sequence) {
    Header h;
    h.session = session;
    h.sequence = sequence;
    gaps.arrived(h, key);
  };
  arrive(1, 0, 10);  // joined late: nothing is known to be lost
  arrive(1, 1, 1);
  arrive(1, 0, 11);
  EXPECT_EQ(gaps.lost(), 0u);
  arrive(1, 0, 14);
  EXPECT_EQ(gaps.lost(), 2u);
  arrive(1, 0, 12);  // late
  arrive(1, 1, 2);
  EXPECT_EQ(gaps.lost(), 2u);
  arrive(2, 0, 1);  // a restarted sender
  EXPECT_EQ(gaps.lost(), 2u);
  for (std::uint64_t session = 100; session < 1100; ++session) arrive(session, 0, 1);  // more than it remembers
  EXPECT_EQ(gaps.lost(), 2u);
}

}  // namespace
}  // namespace palp::test::validate_test
