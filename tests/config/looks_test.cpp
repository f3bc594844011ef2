// Looks: what a scene file may say of them, and what follows where it says nothing.
#include "config/looks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/config/spoilt_scene.h"

namespace palp::test::looks_test {
namespace {

using Rgb = std::array<float, 3>;

const std::string kColor = "color = \"#102030\"";

SceneConfig with_material(const std::string& keys) { return read(replaced(kScene, kColor, keys)); }

ColoredLook fluid_look(const std::string& keys) {
  const SceneConfig s = with_material(keys);
  return look_of(BodyKind::fluid, s.materials[0], s.bodies[0].look, s.bodies[0].color);
}

// The look of that name of a liquid as thin as the scene's, which foams whatever it is called.
Look named_and_thin(const char* name) {
  Look look = named_look(name).look;
  look.foam = 1;
  return look;
}

TEST(Looks, EveryNameIsALookThatTheBusTakes) {
  std::set<std::string> names;
  for (const std::string& name : look_names()) {
    SCOPED_TRACE(name);
    EXPECT_TRUE(names.insert(name).second) << "twice";
    const auto [color, look] = named_look(name);
    for (const float c : color) EXPECT_TRUE(c >= 0 && c <= 1);
    for (const float share : {look.roughness, look.metallic, look.grain}) EXPECT_TRUE(share >= 0 && share <= 1);
    EXPECT_TRUE(look.refractive_index >= 1 && look.refractive_index <= kMostRefractiveIndex);
    EXPECT_TRUE(look.scattering_length >= 0 && look.scattering_length <= kMostScatteringLength);
    for (const float a : look.absorption_per_m) EXPECT_TRUE(a >= 0 && a <= kMostAbsorptionPerM);
    EXPECT_FALSE(look.clear && look.metallic > 0);
    EXPECT_EQ(look.clear, look.absorption_per_m != Rgb{}) << "only what is clear absorbs on a way";
  }
  EXPECT_THROW(named_look("nonsense"), std::logic_error);
}

// The colour of a clear look and its absorption are of the same matter: legends show the one, pictures the other.
TEST(Looks, ColorsOfClearOnesAreWhatTheyLeaveOfWhiteLight) {
  for (const char* name : {"honey", "oil", "juice"}) {
    const auto [color, look] = named_look(name);
    const Rgb needed = absorption_of(color);
    EXPECT_GT(look.absorption_per_m[2], look.absorption_per_m[1]) << name;
    EXPECT_GT(look.absorption_per_m[1], look.absorption_per_m[0]) << name;
    EXPECT_GT(needed[2], needed[0]) << name;
  }
}

TEST(Looks, AFileNamesOneOrGivesNumbers) {
  const ColoredLook honey = fluid_look("look = \"honey\"");
  EXPECT_EQ(honey.look, named_and_thin("honey"));
  EXPECT_EQ(honey.color, named_look("honey").color);

  const ColoredLook table = fluid_look(
      "look = {base = \"oil\", color = \"#ff0000\", roughness = 0.2, metallic = 0.5, refractive_index = 1.7, "
      "absorption_per_m = [1, 2, 3], scattering_length = 0.01, grain = 0.25}");
  EXPECT_EQ(table.color, (Rgb{1, 0, 0}));
  EXPECT_EQ(table.look, (Look{true, 0.2f, 0.5f, 1.7f, {1, 2, 3}, 0.01f, 0.25f, 1}));

  const ColoredLook opaque = fluid_look("look = {base = \"oil\", clear = false}");
  EXPECT_FALSE(opaque.look.clear);
  EXPECT_EQ(opaque.look.absorption_per_m, Rgb{}) << "of what is not clear";
}

TEST(Looks, ThinLiquidsFoamAndNothingElseUnlessItSaysSo) {
  const auto foam = [](BodyKind kind, auto&& change) {
    MaterialConfig m;
    change(m);
    return look_of(kind, m).look.foam;
  };
  const auto of = [&](double viscosity) {
    return foam(BodyKind::fluid, [&](MaterialConfig& m) { m.viscosity = viscosity; });
  };
  EXPECT_EQ(of(0), 1);
  EXPECT_EQ(of(1e-3), 1);
  EXPECT_NEAR(of(0.0158), 0.5, 1e-2);
  for (const double thick : {0.05, 2.0, 100.0}) EXPECT_EQ(of(thick), 0) << thick;
  EXPECT_EQ(foam(BodyKind::elastic, [](MaterialConfig&) {}), 0);
  EXPECT_EQ(foam(BodyKind::fluid, [](MaterialConfig& m) { m.cooking_temperature = 345; }), 0);
  EXPECT_EQ(fluid_look("look = {base = \"honey\", foam = 0.3}").look.foam, 0.3f);
  MaterialConfig ice;
  ice.melting_temperature = 273;
  EXPECT_EQ(changed_look_of(BodyKind::fluid, ice, look_of(BodyKind::fluid, ice)).look.foam, 0) << "it is solid";
}

TEST(Looks, AColorGivesWhatIsClearItsAbsorption) {
  const ColoredLook look = fluid_look("look = \"oil\"\ncolor = \"#ff8000\"");
  EXPECT_EQ(look.color, (Rgb{1, 128 / 255.f, 0}));
  EXPECT_EQ(look.look.absorption_per_m, absorption_of(look.color));
  EXPECT_FLOAT_EQ(look.look.absorption_per_m[0], 0) << "red goes through";
  EXPECT_LT(look.look.scattering_length, named_look("oil").look.scattering_length) << "a dye makes it hazy";
  EXPECT_EQ(fluid_look("look = {base = \"oil\", scattering_length = 7}\ncolor = \"#ff8000\"").look.scattering_length,
            7);
  const float green = std::exp(-look.look.absorption_per_m[1] * kColorDepth);
  EXPECT_NEAR(green, std::pow((128 / 255.0 + 0.055) / 1.055, 2.4), 1e-4);
  for (const float a : absorption_of({0, 0, 0})) EXPECT_TRUE(std::isfinite(a) && a > 50);
}

TEST(Looks, ABodyMayLookOtherwiseThanItsMaterial) {
  const SceneConfig s = read(
      replaced(replaced(kScene, kColor, "look = \"honey\""), "temperature = 300", "temperature = 300\nlook = \"ice\""));
  ASSERT_TRUE(s.bodies[0].look);
  EXPECT_FALSE(s.bodies[1].look);
  EXPECT_EQ(look_of(BodyKind::fluid, s.materials[0], s.bodies[0].look).look, named_and_thin("ice"));
  EXPECT_EQ(look_of(BodyKind::fluid, s.materials[0], s.bodies[1].look).look, named_and_thin("honey"));
}

TEST(Looks, FollowFromThePhysicsWhereNothingIsSaid) {
  const auto usual = [](BodyKind kind, auto&& change) {
    MaterialConfig m;
    change(m);
    return std::string(usual_look(kind, m));
  };
  const auto thick = [&](double viscosity) {
    return usual(BodyKind::fluid, [&](MaterialConfig& m) { m.viscosity = viscosity; });
  };
  EXPECT_EQ(thick(1e-3), "water");
  EXPECT_EQ(thick(0.05), "oil");
  EXPECT_EQ(thick(2), "honey");
  EXPECT_EQ(thick(100), "paste");
  EXPECT_EQ(usual(BodyKind::fluid, [](MaterialConfig& m) { m.cooking_temperature = 345; }), "batter");

  const auto stiff = [&](double young_modulus) {
    return usual(BodyKind::elastic, [&](MaterialConfig& m) { m.young_modulus = young_modulus; });
  };
  EXPECT_EQ(stiff(1e4), "jelly");
  EXPECT_EQ(stiff(2e6), "rubber");
  EXPECT_EQ(stiff(1e9), "plastic");
  EXPECT_EQ(usual(BodyKind::elastic, [](MaterialConfig& m) { m.yield_stress = 1500; }), "dough");
  EXPECT_EQ(usual(BodyKind::elastic, [](MaterialConfig& m) { m.melting_temperature = 273; }), "ice");
  EXPECT_EQ(usual(BodyKind::elastic, [](MaterialConfig& m) { m.melting_temperature = 305; }), "butter");

  for (const BodyKind kind : {BodyKind::rigid, BodyKind::fixed}) {
    const auto heavy = [&](double density) { return usual(kind, [&](MaterialConfig& m) { m.density = density; }); };
    EXPECT_EQ(heavy(7800), "steel");
    EXPECT_EQ(heavy(2500), "stone");
    EXPECT_EQ(heavy(1000), "plastic");
    EXPECT_EQ(heavy(700), "wood");
    EXPECT_EQ(heavy(30), "plastic") << "foam";
    const auto melts_at = [&](double kelvin) {
      return usual(kind, [&](MaterialConfig& m) { m.density = 917, m.melting_temperature = kelvin; });
    };
    EXPECT_EQ(melts_at(273), "ice");
    EXPECT_EQ(melts_at(330), "plastic") << "wax: no wood melts";
  }
  for (const double viscosity : {1e-3, 0.05, 2.0, 100.0}) EXPECT_NO_THROW(named_look(thick(viscosity)));
}

ColoredLook changed(BodyKind kind, const MaterialConfig& m) { return changed_look_of(kind, m, look_of(kind, m)); }

TEST(Looks, WhatChangesStateLooksOtherwise) {
  MaterialConfig m;
  EXPECT_EQ(changed(BodyKind::fluid, m).look, look_of(BodyKind::fluid, m).look) << "it never does";

  m.cooking_temperature = 345;
  EXPECT_EQ(changed(BodyKind::fluid, m).look, named_look("crepe").look);
  EXPECT_EQ(changed(BodyKind::fluid, m).color, named_look("crepe").color);
  m.look = LookConfig{"water", {}, {}, {}, {}, {}, {}, {}, {}, {}};
  EXPECT_TRUE(changed(BodyKind::fluid, m).look.clear) << "what is clear stays so, and turns white";
  EXPECT_LT(changed(BodyKind::fluid, m).look.scattering_length, 0.01f);

  MaterialConfig butter;
  butter.young_modulus = 2e4;
  butter.melting_temperature = 305;
  const ColoredLook solid = look_of(BodyKind::elastic, butter), molten = changed(BodyKind::elastic, butter);
  EXPECT_LT(molten.look.roughness, 0.3f * solid.look.roughness) << "wet";
  EXPECT_EQ(molten.color, solid.color);

  MaterialConfig water;
  water.melting_temperature = 273;
  const ColoredLook liquid = look_of(BodyKind::fluid, water), frozen = changed(BodyKind::fluid, water);
  EXPECT_GT(frozen.look.roughness, 2 * liquid.look.roughness) << "frost";
  EXPECT_LT(frozen.look.scattering_length, 0.2f * liquid.look.scattering_length);
}

TEST(Looks, AFileSaysHowWhatHasChangedLooks) {
  const std::string sets = "cooking_temperature = 345\nyoung_modulus = 1e4\nheat_capacity = 3000\n";
  const SceneConfig s = with_material(sets + "changed_look = {base = \"chocolate\", roughness = 0.7}");
  const ColoredLook set = changed(BodyKind::fluid, s.materials[0]);
  EXPECT_EQ(set.color, named_look("chocolate").color);
  EXPECT_EQ(set.look.roughness, 0.7f);

  const SceneConfig clear = with_material(sets + "look = \"honey\"\nchanged_look = \"chocolate\"");
  EXPECT_TRUE(changed(BodyKind::fluid, clear.materials[0]).look.clear);
  EXPECT_THROW(with_material("changed_look = \"ice\""), ConfigError) << "it never changes state";
}

TEST(Looks, WithoutLookAndColorAViewerChoosesTheColor) {
  EXPECT_EQ(look_of(BodyKind::fluid, MaterialConfig{}).color, kNoColor);
  EXPECT_EQ(look_of(BodyKind::fluid, MaterialConfig{}).look.absorption_per_m, absorption_of(kNoColor));
  EXPECT_EQ(look_of(BodyKind::fluid, MaterialConfig{}, {}, Rgb{1, 0, 0}).color, (Rgb{1, 0, 0}));
}

}  // namespace
}  // namespace palp::test::looks_test
