// Menu and panels in the picture, steered by events as a window sends them.
#include "viewer/panels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "tests/support/eventually.h"
#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"

namespace palp::test::panels_test {
namespace {

constexpr int kWidth = 640, kHeight = 480;
const char* const kList =
    "gravity\t0 0 -9.81\tm/s^2\t-100000\t100000\nmaterial.water.viscosity\t0.05\tPa s\t0\t1e+09\n"
    "stream.particle_rate_hz\t60\tHz\t0\t1000\n";

class PanelsTest : public testing::Test {
 protected:
  void start(PanelDetail shown, bool in_pictures = true, const ViewerSettings& settings = {}) {
    const Session::Send send = [this](CommandKind kind, const std::string& name, const std::string& value) {
      sent_.push_back({kind, name, value});
    };
    keys_ = new KeyHandler;
    stage_.viewer().addEventHandler(keys_);
    session_ = std::make_unique<Session>(stage_, ScalarField::speed, send);
    panels_ = std::make_unique<Panels>(stage_, *session_, send, settings, PanelOptions{shown, in_pictures});
    const SyntheticScene s = synthetic_scene();
    view_.scene = std::make_shared<const SceneDescription>(s.scene);
    view_.frame = std::make_shared<const ParticleFrame>(s.frame);
    view_.poses = std::make_shared<const BodyPoses>(s.poses);
    view_.proxies[0] = s.proxy;
    view_.told[""] = std::make_shared<const std::string>(kList);
    view_.status["sim_server"].process = "sim_server";
    view_.status["sim_server"].metrics = {{"real_time_factor", 0.9}, {"step_p50_us", 400}};
    ASSERT_TRUE(eventually([&] { return (session_->update(view_, now_), session_->surfaces_complete()); },
                           std::chrono::seconds(30)));
    for (int i = 0; i < 3; ++i) picture();
  }

  // One round of the program's loop.
  Picture picture() {
    now_ += 50'000'000;
    view_.frame_time_ns = now_;
    session_->update(view_, now_);
    panels_->update(view_, now_);
    Picture taken = shoot(stage_);
    obey(keys_->take());
    obey(panels_->take_requests());
    return taken;
  }
  void obey(const std::vector<Request>& requests) {
    for (const Request& request : requests) {
      session_->act(request);
      panels_->act(request);
    }
  }

  osgGA::EventQueue& events() {
    auto* context = stage_.viewer().getCamera()->getGraphicsContext();
    return *dynamic_cast<osgViewer::GraphicsWindow&>(*context).getEventQueue();
  }
  // Places in pixels from the upper left corner.
  void move_to(double x, double y) {
    events().mouseMotion(static_cast<float>(x), static_cast<float>(y));
    picture();
  }
  void click(double x, double y) {
    move_to(x, y);
    events().mouseButtonPress(static_cast<float>(x), static_cast<float>(y), 1);
    picture();
    events().mouseButtonRelease(static_cast<float>(x), static_cast<float>(y), 1);
    picture();
  }
  void drag(double x, double y, double to_x, double to_y) {
    move_to(x, y);
    events().mouseButtonPress(static_cast<float>(x), static_cast<float>(y), 1);
    picture();
    for (const double share : {0.3, 0.6, 1.0}) move_to(x + share * (to_x - x), y + share * (to_y - y));
    events().mouseButtonRelease(static_cast<float>(to_x), static_cast<float>(to_y), 1);
    picture();
  }
  void press(int key) {
    events().keyPress(key);
    events().keyRelease(key);
    picture();
  }
  bool was_sent(CommandKind kind) {
    return std::ranges::any_of(sent_, [kind](const Sent& s) { return s.kind == kind; });
  }
  osg::Vec2d place_of(const osg::Vec3d& point) {
    const osg::Vec2d p = stage_.project(point);
    return {p.x(), stage_.height() - p.y()};
  }

  struct Sent {
    CommandKind kind;
    std::string name, value;
  };
  Stage stage_{small_stage(kWidth, kHeight)};
  osg::ref_ptr<KeyHandler> keys_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<Panels> panels_;
  FeedView view_;
  std::vector<Sent> sent_;
  std::int64_t now_ = 100'000'000'000;
};

// A camera that someone has moved stays when panels come and go.
const StoredView kMoved{{0.2, -0.7, 0.4}, {0, 0, 0.02}, {0, 0, 1}};

TEST_F(PanelsTest, PicturesLeaveThemOut) {
  start(PanelDetail::none, false);
  stage_.hud().set_visible(false);
  stage_.set_view(kMoved);
  picture();
  const Picture bare = picture();
  press('p');
  press('p');
  ASSERT_EQ(panels_->settings().panels, PanelDetail::all);
  EXPECT_EQ(differing(bare, picture()), 0);
}

TEST_F(PanelsTest, StandAtTheEdgesAndLeaveTheSceneFree) {
  start(PanelDetail::none);
  stage_.hud().set_visible(false);
  stage_.set_view(kMoved);
  picture();
  const Picture bare = picture();
  press('p');
  EXPECT_EQ(panels_->settings().panels, PanelDetail::menu);
  press('p');
  picture();
  const Picture all = picture();
  const float letter = stage_.hud().font_size();
  const int menu = static_cast<int>(2 * letter);
  int left = kWidth, outside = 0;
  for (int y = 0; y < kHeight - menu; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Pixel p = at(bare, x, y), q = at(all, x, y);
      if (p.r == q.r && p.g == q.g && p.b == q.b) continue;
      left = std::min(left, x);
      outside += x < kWidth - 25 * letter ? 1 : 0;
    }
  }
  EXPECT_EQ(outside, 0);
  EXPECT_NEAR(left, kWidth - 24 * letter, 2);
}

TEST_F(PanelsTest, ButtonsAskForWhatKeysDo) {
  start(PanelDetail::all);
  press(' ');
  EXPECT_TRUE(was_sent(CommandKind::pause));
  sent_.clear();
  const double x = kWidth - 22.5 * stage_.hud().font_size();  // over the first of the buttons
  for (double y = 34; y < 50 && !was_sent(CommandKind::pause); y += 3) click(x, y);
  EXPECT_TRUE(was_sent(CommandKind::pause));
}

TEST_F(PanelsTest, AFieldThatIsDraggedSetsItsParameterOnce) {
  start(PanelDetail::all);
  EXPECT_TRUE(was_sent(CommandKind::get_parameter)) << "the list is looked at again";
  const osg::Matrixd before = stage_.viewer().getCameraManipulator()->getMatrix();
  const double x = kWidth - 11 * stage_.hud().font_size();
  sent_.clear();
  for (double y = 58; y < 110 && !was_sent(CommandKind::set_parameter); y += 7) drag(x, y, x + 30, y);
  ASSERT_TRUE(was_sent(CommandKind::set_parameter));
  const Sent& set = *std::ranges::find(sent_, CommandKind::set_parameter, &Sent::kind);
  EXPECT_EQ(set.name, "gravity");
  EXPECT_NE(set.value, "0 0 -9.81");
  EXPECT_EQ(std::ranges::count(sent_, CommandKind::set_parameter, &Sent::kind), 1);
  EXPECT_EQ(stage_.viewer().getCameraManipulator()->getMatrix(), before) << "the camera is no panel's business";
  EXPECT_FALSE(panels_->picked());
}

TEST_F(PanelsTest, TheBillIsAskedForWhereItsPanelIsOpen) {
  const auto asked = [this] { return std::ranges::count(sent_, std::string(kBillName), &Sent::name); };
  ViewerSettings settings;
  settings.control = settings.reading = settings.plots = false;
  settings.bill = true;
  start(PanelDetail::all, true, settings);
  EXPECT_GE(asked(), 1);
  stage_.hud().set_visible(false);  // whose figures change
  stage_.set_view(kMoved);
  picture();
  const Picture none = picture();
  ASSERT_EQ(differing(none, picture()), 0);
  view_.told[kBillName] =
      std::make_shared<const std::string>("tray on cpu: 900 particles\n\nModules\n  fluid        water\n");
  EXPECT_GT(differing(none, picture()), 500) << "its words are shown";
}

TEST_F(PanelsTest, NobodyAsksForABillThatNobodySees) {
  start(PanelDetail::all);
  EXPECT_EQ(std::ranges::count(sent_, std::string(kBillName), &Sent::name), 0);
}

TEST_F(PanelsTest, TheNextSceneAndTheSameAnewAreAskedFor) {
  start(PanelDetail::menu);
  const auto loaded = [this] {
    std::vector<std::string> names;
    for (const Sent& one : std::exchange(sent_, {}))
      if (one.kind == CommandKind::load_scene) names.push_back(one.name);
    return names;
  };
  const auto tell = [this](const std::string& names) {
    view_.told[kScenesName] = std::make_shared<const std::string>(names);
    picture();
  };
  using Names = std::vector<std::string>;
  EXPECT_GE(std::ranges::count(sent_, std::string(kScenesName), &Sent::name), 1);
  press('N');
  EXPECT_EQ(loaded(), Names{}) << "the server has told of none";
  tell("an_other\n" + view_.scene->name + "\nz_third");
  press('N');
  picture();
  EXPECT_EQ(loaded(), Names{"z_third"});
  press('L');
  EXPECT_EQ(loaded(), Names{""});
  tell("an_other\n" + view_.scene->name);
  press('N');
  picture();
  EXPECT_EQ(loaded(), Names{"an_other"}) << "after the last comes the first";
}

TEST_F(PanelsTest, AClickSaysWhatItMeetsUntilEscape) {
  start(PanelDetail::menu);
  const auto& pose = view_.poses->pose[0].position;
  const osg::Vec2d handle = place_of({pose[0], pose[1], pose[2] + 0.04});
  click(handle.x(), handle.y());
  ASSERT_TRUE(panels_->picked());
  EXPECT_EQ(panels_->picked()->title, "paddle");
  const auto value = [this](const std::string& what) {
    for (const auto& [name, words] : panels_->picked()->lines)
      if (name == what) return words;
    return std::string("none");
  };
  EXPECT_EQ(value("kind"), "rigid");
  EXPECT_NE(value("position").find("0.1050 m"), std::string::npos) << value("position");
  EXPECT_NE(value("density").find("kg/m³"), std::string::npos);
  const Picture marked = picture();
  EXPECT_GT(find(marked, [](Pixel p) { return p.r > 200 && p.g > 130 && p.g < 220 && p.b < 120; }).pixels, 100);
  press(osgGA::GUIEventAdapter::KEY_Escape);
  picture();
  EXPECT_FALSE(panels_->picked());
  EXPECT_FALSE(stage_.viewer().done());
  press(osgGA::GUIEventAdapter::KEY_Escape);
  EXPECT_TRUE(stage_.viewer().done());
}

TEST_F(PanelsTest, AParticleIsToldWithItsFieldAndADragPicksNothing) {
  start(PanelDetail::menu);
  const osg::Vec2d water = place_of({-0.09, -0.04, kDepth});
  drag(water.x(), water.y(), water.x() + 40, water.y());
  EXPECT_FALSE(panels_->picked());
  const osg::Vec2d now = place_of({-0.09, -0.04, kDepth});
  click(now.x(), now.y());
  ASSERT_TRUE(panels_->picked());
  EXPECT_EQ(panels_->picked()->title.substr(0, 9), "particle ");
  const auto& lines = panels_->picked()->lines;
  EXPECT_TRUE(
      std::ranges::any_of(lines, [](const auto& l) { return l.first == "speed" && l.second.ends_with(" m/s"); }));
  EXPECT_TRUE(std::ranges::any_of(lines, [](const auto& l) { return l.first == "body" && l.second == "water"; }));
  // another scene has other particles
  view_.scene = std::make_shared<const SceneDescription>(*view_.scene);
  view_.frame = nullptr;
  picture();
  EXPECT_FALSE(panels_->picked());
}

TEST_F(PanelsTest, ViewsAreStoredAndRecalled) {
  start(PanelDetail::none);
  stage_.set_view(kMoved);
  panels_->act({Action::store_view, 4});
  stage_.go_home();
  EXPECT_GT((stage_.view().eye - kMoved.eye).length(), 0.05);
  press('4');
  EXPECT_LT((stage_.view().eye - kMoved.eye).length(), 1e-6);
  EXPECT_LT((stage_.view().center - kMoved.center).length(), 1e-6);
  press('5');
  EXPECT_LT((stage_.view().eye - kMoved.eye).length(), 1e-6) << "nothing is stored there";
  stage_.set_view({{0, 0, 1}, {0, 0, 0}, {0, 0, 1}});
  EXPECT_LT((stage_.view().eye - kMoved.eye).length(), 1e-6) << "such a view has no direction";
}

TEST_F(PanelsTest, HelpStandsAloneAndSettingsTakeEffect) {
  ViewerSettings settings;
  settings.map = ColorMapKind::viridis;
  settings.held[1] = ValueRange{0, 3};
  settings.theme = Theme::light;
  start(PanelDetail::all, true, settings);
  EXPECT_EQ(stage_.scene().cloud().color_map_kind(), ColorMapKind::viridis);
  EXPECT_EQ(stage_.scene().cloud().range(), (ValueRange{0, 3}));
  const Picture light = picture();
  EXPECT_GT(at(light, kWidth - 3, 100).g, 180) << "the column is light";
  press('h');
  picture();
  EXPECT_LT(at(picture(), kWidth - 3, 100).g, 120) << "the help has the picture to itself";
  press(osgGA::GUIEventAdapter::KEY_Escape);
  EXPECT_FALSE(stage_.hud().help_shown());
  press('v');
  EXPECT_EQ(panels_->settings().map, ColorMapKind::viridis) << "the settings follow the next view";
  picture();
  EXPECT_EQ(panels_->settings().map, ColorMapKind::cividis);
}

}  // namespace
}  // namespace palp::test::panels_test
