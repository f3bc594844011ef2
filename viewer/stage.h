// A window (or off-screen surface) with its camera, its head-up display and the scene: all that it takes to make a
// picture. Several of them can show one scene.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <osg/ref_ptr>
#include <osgViewer/Viewer>

#include "viewer/gl_errors.h"
#include "viewer/gpu_pacing.h"
#include "viewer/home_view.h"
#include "viewer/hud.h"
#include "viewer/media_view.h"
#include "viewer/picking.h"
#include "viewer/scene_graph.h"

namespace palp {

// How well liquids are drawn: quick takes fewer texels and rounds. automatic: quick on a software rasteriser.
enum class Surfaces { automatic, fine, quick };

struct StageOptions {
  int width = 1280;  // [pixels]
  int height = 720;
  int samples = 0;  // per pixel; 0 no anti-aliasing
  int mean_of = 1;  // pictures that one which is read is the mean of, displaced within a pixel: all edges are smooth
  bool headless = false;
  std::string gpu = "auto";  // see egl_window.h; headless only
  std::string title = "palp";
  int x = 80, y = 60;  // of a window, from the upper left corner of the screen [pixels]
  Surfaces surfaces = Surfaces::automatic;
  GlErrorListener on_gl_error;  // of the stage's context until it is closed; unset: OSG's own checks alone
};

// Rows from the bottom up, three bytes a pixel: R G B.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

// One thread makes and uses it.
class Stage {
 public:
  // Opens a window, or an off-screen surface when options.headless. Throws std::runtime_error when there is none to be
  // had.
  explicit Stage(const StageOptions& options);
  // Opens another window on the scene of the first one, which must outlive it. It draws in the first one's OpenGL
  // context, so that what is on the GPU is there once; shadows are those that the first one's last picture had.
  Stage(const StageOptions& options, Stage& first);
  ~Stage();

  SceneGraph& scene() { return *scene_; }
  const SceneGraph& scene() const { return *scene_; }
  Hud& hud() { return hud_; }
  osgViewer::Viewer& viewer() { return *viewer_; }
  const std::string& renderer() const { return renderer_; }  // what OpenGL calls itself
  bool software_rendered() const;
  int width() const;
  int height() const;

  // Points the camera at scene().content() from the front. A camera that the user has moved is moved back.
  void go_home();
  // Shows the scene beside panels along the right edge that take so many pixels.
  void set_taken_right(double pixels);
  double taken_right() const { return taken_right_; }
  // Does so unless someone has moved the camera since it was sent home.
  void go_home_unless_moved();
  // Puts the camera there, until it is sent home or someone moves it. field_of_view: vertical [degrees].
  void set_camera(const CameraPose& pose, double field_of_view);
  // Adds what is drawn over everything else, in pictures, too.
  void add_overlay(osg::Node* overlay) { viewer_->getSceneData()->asGroup()->addChild(overlay); }
  // Returns where the camera is, and puts it there. A view without a direction is passed over.
  StoredView view() const;
  void set_view(const StoredView& view);
  // Moves the camera along with the tools while it is to follow them: seconds [s] are those since the call before.
  void follow_tools(double seconds);
  void set_following(bool following) { following_ = following; }
  bool following() const { return following_; }
  // Notes that someone wants a picture of this window; returns whether anyone did since the last call.
  void ask_for_picture() { picture_asked_ = true; }
  bool take_picture_wish() { return std::exchange(picture_asked_, false); }
  // Draws on top of each picture, with the context current. in_pictures: also in the pictures that are read.
  void set_overlay(std::function<void()> draw, bool in_pictures);
  void toggle_full_screen();  // of a window
  // Returns the ray through a place of the picture drawn last, in pixels from its lower left corner.
  Ray ray_through(const osg::Vec2d& place) const;
  // Returns how many pixels a length [m] takes there, across the view.
  double pixels_of(double length, const osg::Vec3d& at) const;
  // Draws one picture. read, when given, receives it before it is shown; it is drawn StageOptions::mean_of times then.
  void draw(const std::function<void(Picture&&)>& read = nullptr);
  // Has all that follows drawn by it; null: at once. A stage on a GPU begins with that GPU's own.
  void pace(GpuPacing* pacing);
  const GpuPacing* pacing() const { return pacing_; }
  // Returns where a world point [m] falls, in pixels from the lower left corner of the picture drawn last.
  osg::Vec2d project(const osg::Vec3d& point) const;

 private:
  class ReadBack;
  Stage(const StageOptions& options, Stage* first);
  void keep_tools_in_picture();
  void draw_from(const osg::Matrixd& view, bool hasty, const std::function<void(Picture&&)>& read);
  void open_window(const StageOptions& options);

  bool is_first_;
  std::shared_ptr<SceneGraph> scene_;
  MediaView media_;
  Hud hud_;
  osg::ref_ptr<osgViewer::Viewer> viewer_;
  osg::ref_ptr<osgViewer::GraphicsWindow> window_;
  osg::ref_ptr<ReadBack> read_back_;
  osg::ref_ptr<GpuPacing> pacing_;
  std::string renderer_;
  Surfaces surfaces_;
  int mean_of_;
  GlErrorListener on_gl_error_;
  double field_of_view_ = kFieldOfView;  // vertical [degrees]
  double taken_right_ = 0;               // by panels [pixels]
  bool following_ = false;               // the tools
  bool picture_asked_ = false;
  osg::Matrixd home_;                  // where the camera was sent
  std::array<int, 4> window_place_{};  // of a window before it was full screen: x, y, width, height [pixels]
};

}  // namespace palp
