// Probes against fields and bodies whose values are known.
#include "sim_server/probes/probes.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "tests/support/files.h"
#include "tests/support/scene_builder.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::probes_test {
namespace {

ProbeConfig probe(Quantity quantity, std::vector<Eigen::Vector3d> points = {}) {
  ProbeConfig probe;
  probe.name = "p";
  probe.quantity = quantity;
  probe.points = std::move(points);
  return probe;
}

// Two fluids side by side and a rigid box above them.
class ProbesTest : public ::testing::Test {
 protected:
  ProbesTest() {
    SceneConfig config = scene(0.1);
    config.numerics.solid_particles = true;
    config.bodies.push_back(body("left", BodyKind::fluid, box({0.8, 1, 0.6}, {-0.4, 0, 0})));
    config.bodies.push_back(body("right", BodyKind::fluid, box({0.6, 1, 0.6}, {0.3, 0, 0})));
    config.bodies.push_back(body("block", BodyKind::rigid, box({0.2, 0.4, 0.2}, {0, 0, 0.8})));
    config.gravity = {0, 0, -10};
    set(config);
  }

  void set(const SceneConfig& config) {
    scene_ = sample_scene(config, 100000);
    snapshot_ = {};
    for (std::size_t i = 0; i < scene_.position.size(); ++i) {
      const Eigen::Vector3d& p = scene_.position[i];
      for (int a = 0; a < 3; ++a) snapshot_.position.push_back(static_cast<float>(p[a]));
      for (int a = 0; a < 3; ++a) snapshot_.velocity.push_back(static_cast<float>(a == 1 ? 2 * p.x() : 0));
      snapshot_.density.push_back(500);
      snapshot_.pressure.push_back(static_cast<float>(100 + 10 * p.x()));
    }
  }

  std::vector<ProbeRow> rows(const ProbeConfig& p) {
    ProbeSampler sampler(scene_);
    sampler.load(&snapshot_, output_);
    return sampler.evaluate(p);
  }
  ProbeRow row(const ProbeConfig& p) {
    const auto all = rows(p);
    EXPECT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].size(), probe_columns(p).size());
    return all[0];
  }

  Scene scene_;
  Snapshot snapshot_;
  StepOutput output_;
};

TEST_F(ProbesTest, FieldsAreInterpolatedOverFluidOnly) {
  output_.time = 0.5;
  ProbeRow r = row(probe(Quantity::pressure, {{0.1, 0.03, 0.02}}));
  EXPECT_EQ(*r[0], 0.5);
  EXPECT_NEAR(*r[1], 101, 0.1);
  EXPECT_NEAR(*row(probe(Quantity::density, {{0.1, 0, 0}}))[1], 500, 1e-3);
  r = row(probe(Quantity::velocity, {{-0.2, 0, 0}}));
  EXPECT_NEAR(*r[1], 0, 1e-9);
  EXPECT_NEAR(*r[2], -0.4, 0.01);
  // a constant field comes out exactly, also at the surface
  snapshot_.pressure.assign(snapshot_.pressure.size(), 7);
  EXPECT_NEAR(*row(probe(Quantity::pressure, {{0.6, 0.5, 0.3}}))[1], 7, 1e-6);
  // nothing there: inside the rigid body, and in the air
  EXPECT_FALSE(row(probe(Quantity::pressure, {{0, 0, 0.8}}))[1]);
  EXPECT_FALSE(row(probe(Quantity::velocity, {{-0.9, -0.9, 0.9}}))[3]);
  EXPECT_FALSE(row(probe(Quantity::temperature, {{0, 0, 0}}))[1]);
}

// Water of 7 Pa in a corner of two solids, 0.6 m deep.
TEST_F(ProbesTest, AGaugeInAWallReadsWhatTheWallBears) {
  SceneConfig config = scene(0.1);
  config.bodies.push_back(body("floor", BodyKind::fixed, box({2, 2, 0.4}, {0, 0, -0.2})));
  config.bodies.push_back(body("wall", BodyKind::fixed, box({0.2, 2, 0.8}, {-0.9, 0, 0.4})));
  config.bodies.push_back(body("water", BodyKind::fluid, box({0.8, 1, 0.6}, {-0.4, 0, 0.3})));
  set(config);
  snapshot_.support = 0.3;
  snapshot_.pressure.assign(snapshot_.pressure.size(), 7);
  const auto gauge = [&](double x, double y, double z) { return row(probe(Quantity::wall_pressure, {{x, y, z}}))[1]; };
  const double bound = 7 * value_of(tol::kWallPressure);
  EXPECT_NEAR(*gauge(-0.4, 0, 0), 7, bound) << "under water";
  EXPECT_NEAR(*gauge(-0.4, 0, -1e-6), 7, bound) << "under water, by rounding within the floor";
  EXPECT_NEAR(*gauge(-0.8, 0, 0.3), 7, bound) << "beside water";
  EXPECT_NEAR(*gauge(-0.8, 0, 0), 7, bound) << "where two solids meet";
  EXPECT_NEAR(*gauge(0, 0, 0), 3.5, bound) << "where the water ends";
  EXPECT_NEAR(*gauge(0, 0.5, 0), 1.75, bound) << "at its corner";
  EXPECT_EQ(*gauge(0.5, 0, 0), 0) << "dry";
  EXPECT_FALSE(gauge(-0.4, 0, -0.3)) << "within the floor";
  // beyond the support radius from the other wall a face bears 7 Pa where it is wet, whatever the kernel spreads
  double force = 0;
  for (double x = -0.475; x < 0.35; x += 0.05)
    for (double y = -0.875; y < 0.9; y += 0.05) force += 0.05 * 0.05 * *gauge(x, y, 0);
  EXPECT_NEAR(force, 7 * 0.5 * 1.0, bound) << "the force on the face";
}

// By method "paper" solids act by their particles.
TEST_F(ProbesTest, AGaugeReadsByMethodPaperToo) {
  SceneConfig config = scene(0.1);
  config.method = Method::paper;
  ShapeConfig drum = box(Eigen::Vector3d::Zero());
  drum.type = ShapeType::cylinder;
  drum.radius = 0.8;
  drum.height = 0.4;
  config.bodies.push_back(body("drum", BodyKind::fixed, drum));
  config.bodies.push_back(body("water", BodyKind::fluid, box({1, 1, 0.6}, {0, 0, 0.5})));
  set(config);
  snapshot_.support = 0.3;
  snapshot_.pressure.assign(snapshot_.pressure.size(), 7);
  EXPECT_NEAR(*row(probe(Quantity::wall_pressure, {{0, 0, 0.2}}))[1], 7, 7 * value_of(tol::kWallPressure));
  EXPECT_FALSE(row(probe(Quantity::wall_pressure, {{0, 0, 0}}))[1]) << "within the drum";
}

TEST_F(ProbesTest, LinesGiveARowForEachPoint) {
  const ProbeConfig line = probe(Quantity::pressure, {{-0.5, 0, 0}, {0, 0, 0}, {0.4, 0, 0}});
  EXPECT_EQ(probe_columns(line), (std::vector<std::string>{"time_s", "x_m", "y_m", "z_m", "pressure_Pa"}));
  const auto all = rows(line);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(*all[2][1], 0.4);
  EXPECT_NEAR(*all[0][4], 95, 0.1);
  EXPECT_NEAR(*all[2][4], 104, 0.1);
}

TEST_F(ProbesTest, InterpolationCrossesPeriodicBoundaries) {
  SceneConfig config = scene(0.1);
  config.periodic = {true, false, false};
  config.bodies.push_back(body("w", BodyKind::fluid, box({2, 0.6, 0.6})));
  set(config);
  for (std::size_t i = 0; i < scene_.position.size(); ++i) {
    snapshot_.pressure[i] = static_cast<float>(std::cos(EIGEN_PI * scene_.position[i].x()));
  }
  // symmetric about the boundary: one side alone would be off
  const double at_edge = *row(probe(Quantity::pressure, {{-1, 0, 0}}))[1];
  EXPECT_NEAR(at_edge, -1, 0.06);
  EXPECT_NEAR(*row(probe(Quantity::pressure, {{1, 0, 0}}))[1], at_edge, 1e-6);
  snapshot_.velocity.assign(snapshot_.velocity.size(), 0);
  for (std::size_t i = 0; i < scene_.position.size(); ++i)
    snapshot_.velocity[3 * i] = scene_.position[i].x() > 0 ? 1.f : -1.f;
  EXPECT_NEAR(*row(probe(Quantity::velocity, {{-1, 0, 0}}))[1], 0, 1e-6);
}

TEST_F(ProbesTest, FrontsFollowTheirFluid) {
  ProbeConfig front = probe(Quantity::front);
  EXPECT_NEAR(*row(front)[1], 0.55, 1e-6);
  front.body = "left";
  EXPECT_NEAR(*row(front)[1], -0.05, 1e-6);
  front.front_max = false;
  front.axis = 2;
  EXPECT_NEAR(*row(front)[1], -0.25, 1e-6);
  EXPECT_EQ(probe_columns(front)[1], "front_z_m");
}

TEST_F(ProbesTest, EnergiesAreThoseOfParticlesAndBodies) {
  double kinetic = 0, potential = 0;
  for (std::size_t i = 0; i < scene_.position.size(); ++i) {
    if (scene_.body[i] == 2) continue;
    const double mass = 500 * 1e-3;
    kinetic += mass / 2 * std::pow(2 * scene_.position[i].x(), 2);
    potential += mass * 10 * scene_.position[i].z();
  }
  potential += 500 * 0.016 * 10 * 0.8;
  ProbeRow r = row(probe(Quantity::energy));
  EXPECT_NEAR(*r[1], kinetic, 1e-5 * kinetic);
  EXPECT_NEAR(*r[2], potential, 1e-5 * potential);
  EXPECT_NEAR(*r[3], kinetic + potential, 1e-5 * potential);
  // the block alone, spinning about its centre: the frame's origin moves
  output_.bodies.resize(3);
  RigidState& state = output_.bodies[2].state;
  state.angular = {3, 0, 0};
  state.linear = -state.angular.cross(Eigen::Vector3d(0, 0, 0.8)) + Eigen::Vector3d(1, 0, 0);
  ProbeConfig block = probe(Quantity::energy);
  block.body = "block";
  r = row(block);
  const double mass = 8, inertia = mass / 12 * (0.16 + 0.04);
  EXPECT_NEAR(*r[1], mass / 2 + inertia / 2 * 9, 1e-9);
}

TEST_F(ProbesTest, ExtremesAreThoseOfTheFluid) {
  const ProbeRow r = row(probe(Quantity::extremes));
  EXPECT_NEAR(*r[1], 1.5, 1e-6);
  EXPECT_NEAR(*r[2], 92.5, 1e-5);
  EXPECT_NEAR(*r[3], 105.5, 1e-5);
  EXPECT_EQ(*r[4], 500);
  EXPECT_EQ(*r[5], 500);
}

TEST_F(ProbesTest, BodiesGivePoseTwistAndWrench) {
  ProbeConfig block = probe(Quantity::body);
  block.body = "block";
  EXPECT_FALSE(needs_snapshot(block));
  ProbeRow r = row(block);
  EXPECT_EQ(*r[7], 1);  // qw
  EXPECT_FALSE(r[14]);  // no force before the first step
  output_.bodies.resize(3);
  output_.bodies[2].state.position = {1, 2, 3};
  output_.bodies[2].force = {4, 5, 6};
  output_.bodies[2].torque = {7, 8, 9};
  r = row(block);
  EXPECT_EQ(*r[3], 3);
  EXPECT_EQ(*r[14], 4);
  EXPECT_EQ(*r[19], 9);
}

// In solids too, and across a contact weighted as bodies in contact are.
TEST_F(ProbesTest, TemperaturesReachIntoSolids) {
  for (std::size_t i = 0; i < scene_.position.size(); ++i)
    snapshot_.temperature.push_back(scene_.body[i] == 2 ? 400.f : scene_.position[i].x() < 0 ? 300.f : 310.f);
  EXPECT_NEAR(*row(probe(Quantity::temperature, {{0, 0, 0.8}}))[1], 400, 1e-3);
  EXPECT_NEAR(*row(probe(Quantity::temperature, {{0, 0, 0}}))[1], 305, 1e-3);
  EXPECT_FALSE(row(probe(Quantity::temperature, {{-0.9, -0.9, 0.9}}))[1]);
}

TEST_F(ProbesTest, HeatIsAddedUp) {
  MaterialConfig& material = scene_.config.materials[0];
  snapshot_.temperature.assign(scene_.position.size(), 300);
  snapshot_.temperature[3] = 280;
  ProbeRow r = row(probe(Quantity::heat));
  EXPECT_FALSE(r[1]) << "nothing conducts";
  EXPECT_EQ(*r[2], 280);
  EXPECT_NEAR(*r[3], 300, 1);
  EXPECT_EQ(*r[4], 300);
  EXPECT_FALSE(r[5]) << "nothing melts";
  material.melting_temperature = 300;
  snapshot_.heat.assign(scene_.position.size(), 2);
  snapshot_.liquid.assign(scene_.position.size(), 0.25f);
  ProbeConfig block = probe(Quantity::heat);
  block.body = "block";
  r = row(block);
  EXPECT_NEAR(*r[1], 2.0 * scene_.bodies[2].count, 1e-9);
  EXPECT_EQ(*r[2], 300);
  EXPECT_NEAR(*r[5], 0.25, 1e-9);
}

TEST_F(ProbesTest, PiecesAreCounted) {
  EXPECT_EQ(*row(probe(Quantity::pieces))[1], 0) << "nothing changes state";
  snapshot_.body_id = scene_.body;
  const auto first = scene_.bodies[1].first;
  for (const std::uint32_t k : {0u, 1u, 5u}) snapshot_.body_id[first + k] = 3 + first;
  snapshot_.body_id[first + 3] = 3 + first + 3;
  ProbeConfig right = probe(Quantity::pieces);
  for (const std::string name : {"", "right", "left"}) {
    right.body = name;
    const ProbeRow r = row(right);
    EXPECT_EQ(*r[1], name == "left" ? 0 : 2) << name;
    EXPECT_NEAR(*r[2], name == "left" ? 0 : 3 * 500 * scene_.volume[first], 1e-9) << name;
  }
}

TEST_F(ProbesTest, StraysAndNonFiniteParticlesDoNoHarm) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e20f};
  for (int round = 0; round < 50; ++round) {
    snapshot_.position[random() % snapshot_.position.size()] = odd[random() % 6];
    snapshot_.velocity[random() % snapshot_.velocity.size()] = odd[random() % 6];
    snapshot_.density[random() % snapshot_.density.size()] = odd[random() % 6];
    snapshot_.pressure[random() % snapshot_.pressure.size()] = odd[random() % 6];
    for (const Quantity q :
         {Quantity::pressure, Quantity::velocity, Quantity::front, Quantity::energy, Quantity::extremes}) {
      for (const auto& value : row(probe(q, {{0.1, 0, 0}}))) {
        if (value) {
          EXPECT_TRUE(std::isfinite(*value));
        }
      }
    }
  }
}

TEST(RateDue, GivesTheRateOverASecond) {
  for (const double rate : {1.0, 3.0, 50.0, 60.0, 333.0, 1000.0}) {
    int count = 0;
    for (std::uint64_t step = 1; step <= 1000; ++step) count += rate_due(step, rate, 1000) ? 1 : 0;
    EXPECT_EQ(count, static_cast<int>(rate));
  }
  EXPECT_TRUE(rate_due(0, 1, 1000));
  EXPECT_FALSE(rate_due(0, 0, 1000));
}

class RecorderTest : public ProbesTest {
 protected:
  RecorderTest() {
    SceneConfig config = scene_.config;
    ProbeConfig fast = probe(Quantity::pressure, {{0.1, 0, 0}}), slow = probe(Quantity::body), empty = fast;
    fast.name = "fast";
    fast.rate_hz = 500;
    slow.name = "slow";
    slow.body = "block";
    slow.rate_hz = 100;
    empty.name = "empty";
    empty.points = {{-0.9, -0.9, 0.9}};
    empty.rate_hz = 100;
    config.probes = {fast, slow, empty};
    set(config);
  }
  std::vector<std::string> lines(const std::string& name) {
    std::ifstream in(folder_ + "/" + name);
    std::vector<std::string> all;
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  }
  const ScratchFolder scratch_;
  std::string folder_ = scratch_ / "probes";
};

TEST_F(RecorderTest, EachProbeHasItsFileAndRate) {
  ProbeRecorder recorder(scene_, folder_ + "/deep");
  folder_ += "/deep";
  for (output_.step = 0; output_.step <= 20; ++output_.step) {
    output_.time = static_cast<double>(output_.step) / 1000;
    EXPECT_EQ(recorder.due(output_.step), output_.step % 2 == 0);
    if (recorder.due(output_.step)) recorder.record(&snapshot_, output_);
  }
  recorder.close();
  const auto fast = lines("fast.csv"), slow = lines("slow.csv"), empty = lines("empty.csv");
  ASSERT_EQ(fast.size(), 12u);
  EXPECT_EQ(fast[0], "time_s,pressure_Pa");
  EXPECT_EQ(fast[2].substr(0, 6), "0.002,");
  ASSERT_EQ(slow.size(), 4u);
  EXPECT_EQ(slow[0].substr(0, 17), "time_s,x_m,y_m,z_");
  ASSERT_EQ(empty.size(), 4u);
  EXPECT_EQ(empty[2], "0.01,");
}

TEST_F(RecorderTest, AFullDiskIsAnError) {
  std::filesystem::create_directories(folder_);
  std::filesystem::create_symlink("/dev/full", folder_ + "/fast.csv");
  const auto run = [&] {
    ProbeRecorder recorder(scene_, folder_);
    recorder.record(&snapshot_, output_);
    recorder.close();
  };
  try {
    run();
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()), folder_ + "/fast.csv: cannot write: No space left on device");
  }
  std::filesystem::remove_all(folder_);
  std::ofstream(folder_) << "in the way";
  EXPECT_THROW(run(), std::runtime_error);
}

}  // namespace
}  // namespace palp::test::probes_test
