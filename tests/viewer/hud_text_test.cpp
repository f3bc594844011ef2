// The words of the head-up display.
#include "viewer/hud_text.h"

#include <gtest/gtest.h>

namespace palp::test {
namespace {

TEST(HudText, UnknownFiguresAreDashesAndBadOnesWarn) {
  HudData data;
  EXPECT_EQ(hud_banner(data), "waiting for sim_server");
  for (const HudRow& row : hud_rows(data)) EXPECT_FALSE(row.warn) << row.label;
  data.connected = true;
  data.frame_age = 0.6;
  data.real_time_factor = 0.5;
  data.bridge_late = 2e-3;
  int warned = 0;
  for (const HudRow& row : hud_rows(data)) warned += row.warn;
  EXPECT_EQ(warned, 3);
  data.paused = true;
  EXPECT_EQ(hud_banner(data), "paused");
  data.server_state = "fault";
  data.server_text = "speed grew past the sound speed";
  EXPECT_EQ(hud_banner(data), "sim_server stopped: speed grew past the sound speed");
}

TEST(HudText, SaysByWhichWayParticlesCome) {
  HudData data;
  data.connected = true;
  data.frame_age = 0.012;
  const auto age = [&] { return hud_rows(data)[2].value; };
  EXPECT_EQ(age(), "12 ms old");
  data.way = "shared memory";
  EXPECT_EQ(age(), "12 ms old  ·  by shared memory");
}

TEST(HudText, AClutchABoundAndScalesOfAHandAreTold) {
  Status bridge;
  bridge.process = "haptic_bridge 0";
  bridge.state = "idle";
  bridge.text = "the shift button is pressed: the hand moves the arm and not the tool";
  const auto read = [&] {
    HudData data;
    data.connected = true;
    read_status({{bridge.process, bridge}}, data);
    return data;
  };
  EXPECT_EQ(read().hand_trouble, "") << "an idle hand is no trouble";
  bridge.metrics = {{"clutch", 1}, {"motion_scale", 1}, {"force_scale", 1}};
  EXPECT_EQ(hud_banner(read()), "haptic_bridge 0 is idle: " + bridge.text);
  EXPECT_EQ(read().scales, "");
  bridge.state = "engaged";
  bridge.metrics = {{"clutch", 0}, {"motion_scale", 2}, {"force_scale", 0.5}};
  bridge.text = "the arm is at a bound, too warm or saturated: the force is halved";
  EXPECT_EQ(hud_banner(read()), "haptic_bridge 0 is engaged: " + bridge.text);
  EXPECT_EQ(read().scales, "motion ×2, force ×0.5");
  EXPECT_NE(hud_rows(read())[5].value.find("motion ×2, force ×0.5"), std::string::npos);
  bridge.text.clear();
  EXPECT_EQ(read().hand_trouble, "");
}

TEST(HudText, WhatIsTouchedStandsBesideTheContactWhileItIsMarked) {
  const auto contact = [](const HudData& data) {
    for (const HudRow& row : hud_rows(data))
      if (row.label == "contact") return row.value + (row.main ? "!" : "");
    return std::string();
  };
  HudData data;
  data.contact = 0.25;
  EXPECT_EQ(contact(data), "25 % rigid");
  data.touched = Touch{0.00123, std::nullopt};
  EXPECT_EQ(contact(data), "25 % rigid  ·  12.3 cm² touched!");
  data.touched->pressure = 345.6;
  EXPECT_EQ(contact(data), "25 % rigid  ·  12.3 cm² touched, 346 Pa in the mean!");
}

TEST(HudText, TimesHaveTheUnitThatSuits) {
  EXPECT_EQ(format_time(42e-6), "42 us");
  EXPECT_EQ(format_time(0.42e-3), "0.42 ms");
  EXPECT_EQ(format_time(0.123), "123 ms");
  EXPECT_EQ(format_time(1.26), "1.3 s");
}

TEST(HudText, AHandThatIsHeldBackIsNamedWithItsCause) {
  std::map<std::string, Status> status;
  status["haptic_bridge 0"].state = "engaged";
  HudData data;
  data.connected = true;
  data.frame_age = 0.01;
  read_status(status, data);
  EXPECT_EQ(hud_banner(data), "");
  status["haptic_bridge 1"].state = "locked";
  status["haptic_bridge 1"].text = "the dead-man switch is open";
  read_status(status, data);
  EXPECT_EQ(hud_banner(data), "haptic_bridge 1 is locked: the dead-man switch is open");
}

TEST(HudText, TheWorstBridgeIsShown) {
  std::map<std::string, Status> status;
  status["haptic_bridge 0"].metrics = {{"rate_hz", 1000}, {"lateness_p99_us", 20}, {"sample_age_p50_ms", 3}};
  status["haptic_bridge 1"].metrics = {{"lateness_p99_us", 700}};
  status["sim_server"].metrics = {{"step_p50_us", 410}, {"real_time_factor", 0.99}};
  HudData data;
  read_status(status, data);
  EXPECT_DOUBLE_EQ(data.bridge_late.value(), 700e-6);
  EXPECT_DOUBLE_EQ(data.bridge_data_age.value(), 3e-3);
  EXPECT_DOUBLE_EQ(data.bridge_rate_hz.value(), 1000);
  EXPECT_DOUBLE_EQ(data.step_time.value(), 410e-6);
  EXPECT_DOUBLE_EQ(data.real_time_factor.value(), 0.99);
}

}  // namespace
}  // namespace palp::test
