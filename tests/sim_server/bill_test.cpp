// The bill of every scene, against what is kept in bills/, and its arithmetic. After a change that is meant:
//     PALP_UPDATE_BILLS=1 build/release/tests/bill_test --gtest_filter='*EveryScene*'
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sim_server/explain.h"
#include "sim_server/physics/real.h"
#include "sim_server/solver/make_simulation.h"
#include "tests/support/files.h"
#include "tests/support/scene_files.h"
#include "tests/support/scenes.h"

namespace palp::test::bill_test {
namespace {

Bill bill_of(const Scene& scene) {
  const auto simulation = make_cpu_simulation(scene);
  return make_bill(*simulation, 0);
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(source_file("config/scenes")))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string stored_file(const std::string& scene) { return source_file("tests/sim_server/bills/" + scene + ".json"); }

bool has_module(const Bill& bill, const std::string& name) {
  return std::any_of(bill.modules.begin(), bill.modules.end(), [&](const BillModule& m) { return m.name == name; });
}

const BillBody& body_of(const Bill& bill, const std::string& name) {
  return *std::find_if(bill.bodies.begin(), bill.bodies.end(), [&](const BillBody& b) { return b.name == name; });
}

using Reasons = std::vector<std::string>;

// A scene of config/scenes with its simulation and its bill, made once.
struct Billed {
  std::unique_ptr<Simulation> simulation;
  Bill bill;
};

const Billed& billed(const std::string& name) {
  static std::map<std::string, Billed> all;
  Billed& one = all[name];
  if (one.simulation) return one;
  one.simulation = make_cpu_simulation(scene_file(name));
  one.bill = make_bill(*one.simulation, 0);
  return one;
}

class EveryScene : public testing::TestWithParam<std::string> {};

TEST_P(EveryScene, HasTheBillThatIsKept) {
  if (sizeof(real) != sizeof(float)) GTEST_SKIP() << "the bills are kept for single precision";
  const std::string text = json_text(json_of(billed(GetParam()).bill, false));
  if (std::getenv("PALP_UPDATE_BILLS") != nullptr) write_text(stored_file(GetParam()), text);
  EXPECT_EQ(text, text_of(stored_file(GetParam()))) << "if this is meant: see the head of this file";
}

// The test counts again what the bill says, from the scene and the back end, by other ways.
TEST_P(EveryScene, HasABillThatAddsUp) {
  const auto& [simulation, bill] = billed(GetParam());
  const Scene& scene = simulation->scene();
  EXPECT_TRUE(simulation->warnings().empty()) << simulation->warnings().front();
  EXPECT_EQ(bill.particles(), scene.position.size());
  std::map<std::string, std::uint32_t> count;
  for (const std::uint32_t b : scene.body) ++count[scene.bodies[b].name];
  for (const BillBody& body : bill.bodies) {
    EXPECT_EQ(body.particles, count[body.name]) << body.name;
    EXPECT_LE(body.out_of_reach, body.particles) << body.name;
  }
  EXPECT_EQ(bill.bytes(), simulation->footprint().bytes());
  EXPECT_GE(bill.bytes(), scene.position.size() * 30) << "a position, a velocity, a mass, a tag and a number each";
  std::multiset<std::string> launches;
  for (const BillStage& stage : bill.stages)
    for (std::uint64_t k = 0; k < stage.launches; ++k) launches.insert(stage.name);
  const std::vector<std::string> done = simulation->footprint().launches;
  EXPECT_EQ(launches, std::multiset<std::string>(done.begin(), done.end()));
  double shares = 0;
  for (const BillStage& stage : bill.stages) {
    EXPECT_GE(stage.share, 0) << stage.name;
    shares += stage.share;
  }
  EXPECT_NEAR(shares, 1, 1e-9);
  EXPECT_EQ(bill.sub_steps, simulation->sub_steps());
  EXPECT_NEAR(bill.dt * bill.sub_steps, 1 / scene.config.rate_hz, 1e-12);
  if (!bill.limits.empty() && !scene.config.numerics.sub_steps) {
    EXPECT_EQ(bill.limits[0].sub_steps, bill.sub_steps);
  }
  for (const BillLimit& one : bill.limits) {
    if (one.limit.avoided_by.empty()) {
      EXPECT_LE(bill.dt, one.limit.dt) << one.limit.by;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, EveryScene, testing::ValuesIn(scene_names()),
                         [](const testing::TestParamInfo<std::string>& scene) { return scene.param; });

TEST(Bill, AFluidAloneIsChargedForNothingElse) {
  const Bill bill = bill_of(pool_of_water());
  ASSERT_EQ(bill.bodies.size(), 1u);
  EXPECT_EQ(bill.bodies[0].reasons, Reasons{"fluid"});
  ASSERT_EQ(bill.modules.size(), 2u);
  EXPECT_TRUE(has_module(bill, "fluid") && has_module(bill, "neighbour lists"));
}

TEST(Bill, ThePlannedOneIsTheMeasuredOneWithoutItsStages) {
  const auto simulation = make_cpu_simulation(scene_file("tray_fluid"));
  const Bill planned = planned_bill(*simulation);
  EXPECT_EQ(simulation->output().step, 0u) << "a server asks for it while it runs";
  Bill measured = make_bill(*simulation, 0);
  EXPECT_EQ(text_of(measured).find(text_of(planned).substr(0, text_of(planned).find("\nMemory"))), 0u);
  EXPECT_EQ(text_of(planned).find("Launches"), std::string::npos);
  EXPECT_EQ(text_of(planned).find("What would"), std::string::npos);
  EXPECT_EQ(planned.arrays, measured.arrays);
}

TEST(Bill, AWallOfAFluidSaysSoAndCountsWhatNoFluidReaches) {
  Scene scene = pool_of_water();
  add_tray(scene, 0, {-0.2, -0.2, 0}, {0.2, 0.2, 0.4}, 0.5);  // ten layers, of which a support of two meets three
  scene.bounds_min = {-1, -1, -1};
  scene.bounds_max = {1, 1, 1};
  scene.config.accuracy = Accuracy::fast;
  const Bill bill = bill_of(scene);
  const BillBody& tray = body_of(bill, "tray");
  EXPECT_EQ(tray.reasons, Reasons{"wall of a fluid"});
  // all that is nearer than the support radius to the inside is met, and nothing that is a cell's diagonal farther
  const Eigen::AlignedBox3d inside(Eigen::Vector3d(-0.2, -0.2, 0), Eigen::Vector3d(0.2, 0.2, 0.4));
  std::uint32_t met = 0, unmet = 0;
  for (std::uint32_t i = scene.bodies[1].first; i < scene.bodies[1].first + scene.bodies[1].count; ++i) {
    const double away = inside.exteriorDistance(scene.position[i]);
    met += away < 0.1 ? 1 : 0;
    unmet += away > 0.1 + 0.05 * std::sqrt(3) ? 1 : 0;
  }
  EXPECT_LE(tray.out_of_reach, tray.particles - met);
  EXPECT_GE(tray.out_of_reach, unmet);
  const auto said = std::count_if(bill.hints.begin(), bill.hints.end(),
                                  [](const std::string& hint) { return hint.find("'tray'") != std::string::npos; });
  EXPECT_EQ(said, 1);
}

TEST(Bill, ABodyThatMeetsOnlyBodiesByADistanceFieldIsMetByNobody) {
  const Bill bill = bill_of(scene_file("tray_rigid"));
  for (const BillBody& body : bill.bodies) EXPECT_TRUE(body.reasons.empty()) << body.name;
  EXPECT_FALSE(has_module(bill, "fluid") || has_module(bill, "walls by particles") ||
               has_module(bill, "neighbour lists"));
  EXPECT_TRUE(has_module(bill, "contact by distance fields"));
}

// Bodies made in code have no distance field.
TEST(Bill, ContactWithoutADistanceFieldNamesTheOther) {
  Scene scene = empty_scene(0.05, {-1, -1, -1}, {1, 1, 1});
  add_material(scene, 500, 0);
  add_body(scene, "floor", BodyKind::fixed, 0, {-0.3, -0.3, -0.1}, {0.3, 0.3, 0});
  add_body(scene, "box", BodyKind::rigid, 0, {-0.1, -0.1, 0.1}, {0.1, 0.1, 0.2});
  EXPECT_EQ(body_of(bill_of(scene), "box").reasons, Reasons{"contact without a distance field with 'floor'"});
  scene.config.method = Method::paper;
  EXPECT_EQ(body_of(bill_of(scene), "floor").reasons, Reasons{"contact by method \"paper\" with 'box'"});
}

TEST(Bill, BondsAndHeatAreReasons) {
  Scene scene = empty_scene(0.05, {-1, -1, -1}, {1, 1, 1});
  add_material(scene, 1000, 0);
  scene.config.materials[0].young_modulus = 1e5;
  add_body(scene, "clamp", BodyKind::fixed, 0, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0});
  const std::uint32_t bar = add_body(scene, "bar", BodyKind::elastic, 0, {-0.1, -0.1, 0}, {0.1, 0.1, 0.3});
  scene.bodies[bar].bonded_to = {0};
  EXPECT_EQ(body_of(bill_of(scene), "clamp").reasons, Reasons{"is bonded to 'bar'"});
  EXPECT_EQ(body_of(bill_of(scene), "bar").reasons, Reasons{"elastic"});
  scene.temperature.assign(scene.position.size(), 300);
  scene.config.materials[0].conductivity = 1;
  scene.config.materials[0].heat_capacity = 1000;
  EXPECT_EQ(body_of(bill_of(scene), "clamp").reasons, Reasons{"is bonded to 'bar'"});  // all is as warm
  scene.temperature[3] = 310;
  EXPECT_EQ(body_of(bill_of(scene), "clamp").reasons, (Reasons{"conducts heat", "is bonded to 'bar'"}));
}

// A limit that an implicit solve or stages avoid is shown, and does not rule.
TEST(Bill, ShowsTheLimitThatIsAvoided) {
  const Bill bill = bill_of(scene_file("stiff_block"));
  const auto avoided = std::find_if(bill.limits.begin(), bill.limits.end(),
                                    [](const BillLimit& one) { return one.limit.avoided_by == "implicit solve"; });
  ASSERT_NE(avoided, bill.limits.end());
  EXPECT_GT(avoided->sub_steps, bill.sub_steps);
}

// Heat runs in some haptic steps only, and the bill says in which.
TEST(Bill, SaysHowOftenAStageRuns) {
  const Scene scene = scene_file("hot_pan");
  const Plan plan = make_plan(scene);
  ASSERT_GT(plan.heat_interval, 1);
  for (const BillStage& stage : bill_of(scene).stages) {
    if (stage.name != "heat" && stage.name != "density") continue;
    const int every = stage.name == "heat" ? plan.heat_interval : 1;
    EXPECT_EQ(stage.every, static_cast<std::uint64_t>(every)) << stage.name;
  }
}

}  // namespace
}  // namespace palp::test::bill_test
