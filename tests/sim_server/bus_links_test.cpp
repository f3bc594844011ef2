// The server's threads on the bus.
#include "sim_server/bus_links.h"

#include <gtest/gtest.h>

#include "sim_server/messages_from_state.h"
#include "sim_server/solver/make_simulation.h"
#include "tests/support/bus.h"
#include "tests/support/scenes.h"

namespace palp::test {
namespace {

using namespace std::chrono_literals;

ProxySample sample(double sim_time, std::uint32_t flags) {
  ProxySample s;
  s.flags = flags;
  s.sim_time = sim_time;
  return s;
}

// A slow server's answer comes again and again, a few times; that of one that is paused or coupled to nobody does not.
TEST(HapticLink, SendsAnAnswerAgainUntilThereIsANewerOne) {
  Scene scene;
  scene.proxies.resize(1);
  const auto out = open_bus(options_for(Vendor::cyclone)), in = open_bus(options_for(Vendor::cyclone));
  const auto reader = in->reader<ProxySample>();
  HapticLink link(*out, scene);
  std::vector<Received<ProxySample>> all;
  const auto comes = [&](std::uint64_t sequence) {
    reader->take_all(all);
    return !all.empty() && all.back().message.header.sequence >= sequence;
  };
  ASSERT_TRUE(eventually([&] {  // until both have found each other
    link.put(0, sample(0.25, kHealthy | kPaused));
    link.flush();
    return reader->wait(50ms) && comes(1);
  }));
  while (reader->wait(100ms)) comes(1);
  for (const std::uint32_t flags : {kHealthy | kEngaged, kHealthy | kPaused}) {
    const std::uint64_t first = all.back().message.header.sequence + 1,
                        last = first + ((flags & kEngaged) ? kMostRepeats : 0);
    all.clear();
    link.put(0, sample(0.5, flags));
    link.flush();
    ASSERT_TRUE(eventually([&] { return comes(last); }));
    while (reader->wait(100ms)) comes(last);
    for (const Received<ProxySample>& r : all) {  // a busy reader may have missed some
      EXPECT_EQ(r.message.sim_time, 0.5);
      EXPECT_EQ(r.message.flags, r.message.header.sequence == first ? flags : flags | kRepeated);
    }
    EXPECT_EQ(all.back().message.header.sequence, last);
  }
}

// A body that changes state has no surface of its own.
TEST(SceneDescription, GivesASoftBodyItsSurfaceAndWhereItsParticlesRest) {
  SceneConfig config = scene(0.01);
  MaterialConfig& m = config.materials[0];
  m.young_modulus = 1e4;
  m.poisson_ratio = 0.3;
  m.heat_capacity = 1000;
  m.conductivity = 1;
  config.materials.push_back(m);
  config.materials[1].name = "melts";
  config.materials[1].melting_temperature = 300;
  config.materials[1].latent_heat = 2000;
  BodyConfig jelly = body("jelly", BodyKind::elastic, box({0.05, 0.04, 0.03}));
  jelly.position = {0.1, 0.2, 0.3};
  jelly.temperature = 290;
  BodyConfig butter = jelly;
  butter.name = "butter";
  butter.material = "melts";
  butter.position = {-0.1, 0.2, 0.3};
  config.bodies = {jelly, butter};
  const auto simulation = make_cpu_simulation(sample_scene(config, 1000));
  const SceneDescription out = describe_scene(*simulation);
  const BodyDescription& soft = out.bodies[0];
  ASSERT_EQ(soft.rest.size(), 3 * 60u);
  ASSERT_EQ(soft.vertices.size(), 3 * 8u);
  EXPECT_EQ(soft.triangles.size(), 3 * 12u);
  Eigen::AlignedBox3f surface, particles;  // in the world
  for (std::size_t i = 0; i < soft.vertices.size(); i += 3) surface.extend(Eigen::Vector3f(soft.vertices.data() + i));
  for (std::size_t i = 0; i < soft.rest.size(); i += 3) particles.extend(Eigen::Vector3f(soft.rest.data() + i));
  EXPECT_LT((surface.min() - Eigen::Vector3f(0.075f, 0.18f, 0.285f)).norm(), 1e-6);
  EXPECT_LT((particles.min() - surface.min() - Eigen::Vector3f::Constant(0.005f)).norm(), 1e-6);
  EXPECT_LT((surface.max() - particles.max() - Eigen::Vector3f::Constant(0.005f)).norm(), 1e-6);
  EXPECT_TRUE(out.bodies[1].vertices.empty());
  EXPECT_TRUE(out.bodies[1].rest.empty());
}

}  // namespace
}  // namespace palp::test
