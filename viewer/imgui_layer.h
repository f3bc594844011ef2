// Dear ImGui in the stage's context: events go in, windows are drawn on top of each picture.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include <osg/Vec2d>
#include <osg/ref_ptr>

#include "viewer/settings.h"
#include "viewer/stage.h"

struct ImGuiContext;

namespace palp {

// One thread makes and uses it, the one that renders. The stage must outlive it.
class ImguiLayer {
 public:
  // build: describes the windows with calls of ImGui; called in each picture while the layer is shown. in_pictures:
  // they are also in the pictures that are read.
  ImguiLayer(Stage& stage, std::function<void()> build, bool in_pictures);
  ~ImguiLayer();
  ImguiLayer(const ImguiLayer&) = delete;
  ImguiLayer& operator=(const ImguiLayer&) = delete;

  // The height of letters [pixels], from the next picture on.
  void set_font_size(float pixels);
  void set_theme(Theme theme);
  // Returns the places that were clicked since the last call outside of all windows and without dragging, in pixels
  // from the picture's lower left corner.
  std::vector<osg::Vec2d> take_clicks();

 private:
  class Events;
  void draw();
  void load_font();

  Stage& stage_;
  std::function<void()> build_;
  ImGuiContext* context_;
  osg::ref_ptr<Events> events_;
  double drawn_at_ = 0;  // [s]
  float font_size_ = 14, loaded_font_size_ = 0;
  bool started_ = false;  // what it has in OpenGL is there
};

}  // namespace palp
