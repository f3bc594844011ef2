// A scene's particles and bodies: what is sampled, and what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>

#include "config/error.h"
#include "sim_server/scene/particle_count.h"
#include "tests/support/files.h"
#include "tests/support/scene_builder.h"
#include "tests/support/seed.h"

namespace palp::test::scene_test {
namespace {

std::string fault_of(const SceneConfig& config, std::size_t max_particles = 1000000) {
  try {
    sample_scene(config, max_particles);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(Scene, RigidBodiesHaveExactMassAndMoveAsOne) {
  SceneConfig config = scene(0.05);
  config.numerics.solid_particles = true;
  BodyConfig from = body("ball", BodyKind::rigid, sphere(0.2, {0.1, 0, 0}));
  from.position = {0.2, 0.3, -0.1};
  from.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  from.velocity = {1, 2, 3};
  from.angular_velocity = {0.3, -0.2, 0.5};
  config.bodies.push_back(from);
  const Scene s = sample_scene(config, 100000);
  const Body& b = s.bodies[0];
  const double volume = 4.0 / 3 * EIGEN_PI * 0.008;
  EXPECT_NEAR(b.volume, volume, 1e-12);
  EXPECT_NEAR(b.mass, 500 * volume, 1e-9);
  EXPECT_LT((b.center - Eigen::Vector3d(0.1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((b.inertia - 0.4 * b.mass * 0.04 * Eigen::Matrix3d::Identity()).norm(), 1e-9);
  EXPECT_FALSE(b.surface.triangles.empty());
  const Eigen::Vector3d center = b.position + b.orientation * b.center;
  double sum = 0;
  for (std::size_t i = 0; i < s.position.size(); ++i) {
    sum += s.volume[i];
    EXPECT_LE((s.position[i] - center).norm(), 0.2);
    const Eigen::Vector3d expected = from.velocity + from.angular_velocity.cross(s.position[i] - center);
    EXPECT_LT((s.velocity[i] - expected).norm(), 1e-12);
  }
  EXPECT_NEAR(sum, volume, 1e-12);
  EXPECT_TRUE(s.temperature.empty());
}

TEST(Scene, HasAsManyParticlesAsWanted) {
  const std::string folder = PALP_SOURCE_DIR "/config/scenes/";
  for (const char* state : {"fluid", "elastic", "rigid", "static"}) {
    for (const std::size_t wanted : {1000, 3000, 10000, 30000}) {
      const std::string file = folder + "cuboid_" + state + ".toml";
      const Scene s = sample_scene(load_scene_with_particles(file, {}, wanted), 1000000);
      SCOPED_TRACE(particle_choice(s, wanted));
      const std::size_t block =
          std::find_if(s.bodies.begin(), s.bodies.end(), [](const Body& b) { return b.name == "cuboid"; })->sites;
      EXPECT_EQ(matter_particles(s), block) << "the tool and what holds the cuboid do not count";
      EXPECT_NEAR(static_cast<double>(block), static_cast<double>(wanted), 0.1 * static_cast<double>(wanted));
    }
  }
  // curved matter in several bodies
  const Scene s = sample_scene(load_scene_with_particles(folder + "submerged_sphere.toml", {}, 20000), 1000000);
  EXPECT_NEAR(static_cast<double>(matter_particles(s)), 20000, 1000) << particle_choice(s, 20000);
  EXPECT_THROW(load_scene_with_particles(folder + "taylor_green.toml", {}, 1000), ConfigError) << "read from a file";
}

TEST(Scene, BodiesFollowOneAnotherAndProxiesFindTheirs) {
  SceneConfig config = scene(0.1);
  config.bodies.push_back(body("fluid", BodyKind::fluid, box({0.5, 0.5, 0.5})));
  config.bodies.push_back(body("tool", BodyKind::rigid, box({0.2, 0.2, 0.2}, {0.6, 0, 0})));
  config.bodies[0].temperature = 300;
  config.bodies[1].temperature = 320;
  config.materials[0].conductivity = 1;  // so that the solid has particles
  ProxyConfig proxy;
  proxy.device = 3;
  proxy.body = "tool";
  proxy.handle = {0, 0, 0.1};
  config.proxies.push_back(proxy);
  const Scene s = sample_scene(config, 100000);
  EXPECT_EQ(s.bodies[0].first, 0u);
  EXPECT_EQ(s.bodies[0].count, 125u);
  EXPECT_EQ(s.bodies[1].first, 125u);
  EXPECT_EQ(s.bodies[1].count, 8u);
  EXPECT_EQ(s.body[124], 0u);
  EXPECT_EQ(s.body[125], 1u);
  ASSERT_EQ(s.proxies.size(), 1u);
  EXPECT_EQ(s.proxies[0].device, 3u);
  EXPECT_EQ(s.proxies[0].body, 1u);
  ASSERT_EQ(s.temperature.size(), 133u);
  EXPECT_EQ(s.temperature[0], 300);
  EXPECT_EQ(s.temperature[132], 320);
  EXPECT_TRUE(s.bodies[0].surface.triangles.empty());
}

TEST(Scene, OverlapsNameBothBodies) {
  SceneConfig config = scene(0.1);
  config.bodies.push_back(body("water", BodyKind::fluid, box({1, 1, 1})));
  config.bodies.push_back(body("stone", BodyKind::rigid, sphere(0.2)));
  std::string fault = fault_of(config);
  EXPECT_EQ(fault.rfind("s.toml:1: body 'stone' overlaps body 'water' near (", 0), 0u) << fault;

  // a stone so thin that no particle centres come close to the water's, yet water is inside it
  config.bodies[1] = body("plate", BodyKind::fixed, box({0.3, 0.3, 0.11}, {0.05, 0.05, 0}));
  EXPECT_NE(fault_of(config).find("'plate' overlaps body 'water'"), std::string::npos);

  // side by side is fine, and so is a hole cut for it
  config.bodies[1] = body("stone", BodyKind::rigid, box({0.4, 1, 1}, {0.7, 0, 0}));
  EXPECT_EQ(fault_of(config), "");
  config.bodies[1] = body("stone", BodyKind::rigid, sphere(0.2));
  config.bodies[0].shapes.push_back(sphere(0.2));
  config.bodies[0].shapes[1].subtract = true;
  EXPECT_EQ(fault_of(config), "");

  // two fluids a quarter spacing into one another
  config.bodies[0] = body("water", BodyKind::fluid, box({0.5, 0.5, 0.5}));
  config.bodies[1] = body("oil", BodyKind::fluid, box({0.5, 0.5, 0.5}, {0.44, 0, 0}));
  EXPECT_NE(fault_of(config).find("'oil' overlaps body 'water'"), std::string::npos);
}

// The springs of contact would throw them apart, also where no particle's centre is inside.
TEST(Scene, SolidsMayNotBePressedTogether) {
  SceneConfig config = scene(0.1);
  config.bodies.push_back(body("table", BodyKind::fixed, box({1, 1, 0.2}, {0, 0, -0.1})));
  config.bodies.push_back(body("stone", BodyKind::rigid, box({0.2, 0.2, 0.2}, {0, 0, 0.06})));
  EXPECT_NE(fault_of(config).find("'stone' overlaps body 'table'"), std::string::npos) << fault_of(config);
  config.bodies[1].shapes[0].position.z() = 0.08;
  EXPECT_EQ(fault_of(config), "");
  // a large stone on a narrow post, whose corners are the ones inside
  config.bodies[0] = body("post", BodyKind::fixed, box({0.2, 0.2, 0.4}, {0, 0, -0.2}));
  config.bodies[1] = body("stone", BodyKind::rigid, box({0.8, 0.8, 0.2}, {0, 0, 0.06}));
  EXPECT_NE(fault_of(config).find("'stone' overlaps body 'post'"), std::string::npos) << fault_of(config);
  // a stone as wide as the post, whose corners are on the post's very sides
  config.bodies[1] = body("stone", BodyKind::rigid, box({0.2, 0.2, 0.2}, {0, 0, 0.06}));
  EXPECT_NE(fault_of(config).find("'stone' overlaps body 'post'"), std::string::npos) << fault_of(config);
  config.bodies[1].shapes[0].position.z() = 0.08;
  EXPECT_EQ(fault_of(config), "");
}

// Half a spacing into one another they would burst apart.
TEST(Scene, ElasticBodiesMayNotBePressedTogether) {
  SceneConfig config = scene(0.1);
  config.materials[0].young_modulus = 1e5;
  config.materials[0].poisson_ratio = 0.3;
  config.bodies.push_back(body("jelly", BodyKind::elastic, box({0.5, 0.5, 0.5})));
  config.bodies.push_back(body("cake", BodyKind::elastic, box({0.5, 0.5, 0.5}, {0.46, 0, 0})));
  EXPECT_NE(fault_of(config).find("'cake' overlaps body 'jelly'"), std::string::npos);
  config.bodies[1].shapes[0].position.x() = 0.48;
  EXPECT_EQ(fault_of(config), "");
}

TEST(Scene, OverlapsAreSeenAcrossPeriodicBoundaries) {
  SceneConfig config = scene(0.1);
  config.periodic = {true, false, false};
  config.bodies.push_back(body("a", BodyKind::fluid, box({1, 0.5, 0.5}, {-0.5, 0, 0})));
  config.bodies.push_back(body("b", BodyKind::fluid, box({1, 0.5, 0.5}, {0.5, 0, 0})));
  EXPECT_EQ(fault_of(config), "");
  config.bodies[1].shapes[0].position.x() = 0.56;
  EXPECT_NE(fault_of(config).find("'b' overlaps body 'a'"), std::string::npos);
  config.bodies = {body("long", BodyKind::fluid, box({2.2, 0.5, 0.5}))};
  EXPECT_NE(fault_of(config).find("'long' has two particles in one place"), std::string::npos);
  config.bodies = {body("shifted", BodyKind::fluid, box({2, 0.5, 0.5}, {0.7, 0, 0}))};
  const Scene s = sample_scene(config, 100000);
  for (const Eigen::Vector3d& p : s.position) EXPECT_TRUE(p.x() >= -1 && p.x() < 1);
}

TEST(Scene, ParticlesMustBeInsideTheDomain) {
  SceneConfig config = scene(0.1);
  config.bodies.push_back(body("water", BodyKind::fluid, box({1, 1, 1}, {0.8, 0, 0})));
  EXPECT_EQ(fault_of(config),
            "s.toml:1: body 'water' has 300 of 1000 particles outside the domain, the first at (1.05, -0.45, "
            "-0.45) m; move it or make the [domain] larger");
  // a solid body is not wrapped: it would be torn apart
  config.periodic = {true, true, true};
  EXPECT_EQ(fault_of(config), "");
  config.bodies[0].type = BodyKind::rigid;
  EXPECT_NE(fault_of(config).find("outside the domain"), std::string::npos);
}

TEST(Scene, BodiesAndShapesWithoutParticlesAreRefused) {
  SceneConfig config = scene(0.1);
  config.bodies.push_back(body("dust", BodyKind::fluid, box({0.5, 0.5, 0.5})));
  config.bodies[0].shapes.push_back(box({0.6, 0.6, 0.6}));
  config.bodies[0].shapes[1].subtract = true;
  EXPECT_EQ(fault_of(config),
            "s.toml:1: body 'dust' holds no particle at spacing 0.1 m; make it larger or the spacing finer");
  config.bodies[0].shapes[1] = sphere(0.01, {0.55, 0, 0});
  EXPECT_EQ(
      fault_of(config),
      "s.toml:2: this shape of body 'dust' holds no particle at spacing 0.1 m; make it thicker or the spacing finer");
}

TEST(Scene, TooManyParticlesAreRefusedBeforeTheyAreMade) {
  SceneConfig config = scene(1e-5);
  config.bodies.push_back(body("sea", BodyKind::fluid, box({2, 2, 2})));
  EXPECT_EQ(fault_of(config),
            "s.toml: the scene needs about 8e+15 particles at spacing 1e-05 m (5.44e+08 GB for the host's copy "
            "alone), and memory here allows 1000000; a spacing of 0.021 m would fit");
  config.bodies[0].shapes[0] = sphere(1);
  EXPECT_NE(fault_of(config).find("needs about"), std::string::npos);
  config.numerics.spacing = 0.04;
  config.bodies[0].shapes[0] = box({2, 2, 2});
  EXPECT_EQ(fault_of(config), "");
}

TEST(Scene, TemperatureIsForEveryBodyOrNone) {
  SceneConfig config = scene(0.1);
  config.bodies.push_back(body("warm", BodyKind::fluid, box({0.5, 0.5, 0.5})));
  config.bodies.push_back(body("tool", BodyKind::rigid, box({0.2, 0.2, 0.2}, {0.6, 0, 0})));
  config.bodies[0].temperature = 300;
  EXPECT_EQ(fault_of(config), "s.toml:1: body 'tool' has no temperature, expected one for every body or for none");
}

class FileScene : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    write_text(folder_ / name, text);
    return folder_ / name;
  }
  const ScratchFolder folder_;
};

TEST_F(FileScene, MeshesAreFilledAndDamagedOnesNamed) {
  const std::string tetrahedron = "v 0 0 0\nv 300 0 0\nv 0 300 0\nv 0 0 300\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
  SceneConfig config = scene(0.02);
  config.numerics.solid_particles = true;
  ShapeConfig mesh = box({0, 0, 0});
  mesh.type = ShapeType::mesh;
  mesh.scale = 0.001;
  mesh.file = write("closed.obj", tetrahedron + "f 1 4 3\n");
  config.bodies.push_back(body("tetra", BodyKind::rigid, mesh));
  const Scene s = sample_scene(config, 100000);
  const double volume = 0.3 * 0.3 * 0.3 / 6;
  EXPECT_NEAR(s.bodies[0].volume, volume, 1e-12);
  EXPECT_LT((s.bodies[0].center - Eigen::Vector3d::Constant(0.075)).norm(), 1e-12);
  EXPECT_NEAR(s.bodies[0].inertia(0, 0), 500 * 0.3 * 0.3 * 0.3 / 6 * 0.09 * 3 / 40, 1e-9);  // 3/80 a^2 for each of y, z
  EXPECT_NEAR(static_cast<double>(s.position.size()), volume / 8e-6, 0.15 * volume / 8e-6);
  for (const Eigen::Vector3d& p : s.position) EXPECT_TRUE(p.minCoeff() > 0 && p.sum() < 0.3);

  config.bodies[0].shapes[0].file = write("open.obj", tetrahedron);
  EXPECT_EQ(fault_of(config).rfind("s.toml:2: " + (folder_ / "open.obj") + ": the mesh is open: 3 edges", 0), 0u)
      << fault_of(config);
  config.bodies[0].shapes[0].file = folder_ / "missing.obj";
  EXPECT_EQ(fault_of(config), "s.toml:2: " + (folder_ / "missing.obj") + ": no such file");
}

TEST_F(FileScene, ParticlesComeFromCsvWithPoseAndVelocity) {
  SceneConfig config = scene(0.1);
  ShapeConfig shape = box({0, 0, 0}, {0, 0, 0.5});
  shape.type = ShapeType::particles;
  shape.file = write("p.csv", "x,y,z,vx,vy,vz,temperature\n0.1,0,0,1,0,0,290\n0.3,0,0,0,1,0,291\n");
  config.bodies.push_back(body("p", BodyKind::fluid, shape));
  config.bodies[0].orientation = Eigen::Quaterniond(Eigen::AngleAxisd(EIGEN_PI / 2, Eigen::Vector3d::UnitZ()));
  config.bodies[0].velocity = {0, 0, 2};
  const Scene s = sample_scene(config, 100);
  ASSERT_EQ(s.position.size(), 2u);
  EXPECT_LT((s.position[0] - Eigen::Vector3d(0, 0.1, 0.5)).norm(), 1e-12);
  EXPECT_LT((s.velocity[0] - Eigen::Vector3d(0, 1, 2)).norm(), 1e-12);
  EXPECT_LT((s.velocity[1] - Eigen::Vector3d(-1, 0, 2)).norm(), 1e-12);
  EXPECT_EQ(s.temperature, (std::vector<double>{290, 291}));
  EXPECT_NEAR(s.volume[0], 1e-3, 1e-15);
  config.bodies[0].shapes[0].file = write("twice.csv", "x,y,z\n0,0,0\n0,0,0\n");
  EXPECT_EQ(fault_of(config),
            "s.toml:1: body 'p' has two particles in one place, near (0, 0, 0.5) m; leave one of them out of " +
                config.bodies[0].shapes[0].file);
  // springs between elastic particles get stiffer than a step allows as they get nearer
  config.bodies[0].type = BodyKind::elastic;
  config.materials[0].young_modulus = 1e5;
  config.bodies[0].shapes[0].file = write("near.csv", "x,y,z\n0,0,0\n0.049,0,0\n0.2,0,0\n");
  EXPECT_EQ(fault_of(config),
            "s.toml:1: body 'p' has two particles less than 0.05 m (half a spacing) apart, near (0, 0, 0.5) m; "
            "leave one of them out of " +
                config.bodies[0].shapes[0].file);
  config.bodies[0].shapes[0].file = write("apart.csv", "x,y,z\n0,0,0\n0.051,0,0\n0.2,0,0\n");
  EXPECT_EQ(fault_of(config), "");
  config.bodies[0].shapes[0].file = write("bad.csv", "x,y,z\n0,0,zero\n");
  EXPECT_NE(fault_of(config).find("bad.csv:2: z is 'zero', expected a number from -1e+09 to 1e+09"), std::string::npos);
}

// Particles in, particles out: how many and how they lie does not depend on where the body is.
TEST(Scene, SamplingMovesWithTheBody) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  SceneConfig config = scene(0.05);
  config.numerics.solid_particles = true;
  config.bodies.push_back(body("b", BodyKind::rigid, sphere(0.15)));
  config.bodies[0].shapes.push_back(box({0.1, 0.1, 0.4}, {0, 0, 0.2}));
  const Scene still = sample_scene(config, 100000);
  for (int round = 0; round < 5; ++round) {
    const Eigen::Vector3d t = 0.4 * Eigen::Vector3d(unit(random), unit(random), unit(random));
    const Eigen::Quaterniond q(Eigen::AngleAxisd(3 * unit(random), Eigen::Vector3d(1, unit(random), 0).normalized()));
    config.bodies[0].position = t;
    config.bodies[0].orientation = q;
    const Scene moved = sample_scene(config, 100000);
    ASSERT_EQ(moved.position.size(), still.position.size());
    for (std::size_t i = 0; i < still.position.size(); ++i) {
      EXPECT_LT((moved.position[i] - (q * still.position[i] + t)).norm(), 1e-12);
    }
    EXPECT_EQ(moved.bodies[0].inertia, still.bodies[0].inertia);
  }
}

}  // namespace
}  // namespace palp::test::scene_test
