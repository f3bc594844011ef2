// The windows of a viewer: the first one, with menu, panels and figures, and further ones on the same scene, each with
// a camera of its own. Used by the thread that renders.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include <osg/ref_ptr>

#include "viewer/controls.h"
#include "viewer/options.h"
#include "viewer/panels.h"
#include "viewer/session.h"
#include "viewer/stage.h"

namespace palp {

class Windows {
 public:
  // Opens as many as the options say. All that is handed over must outlive the windows. more_keys: handles the keys of
  // further windows before anything else does; null: nothing does. Throws std::runtime_error where none is to be had.
  Windows(Stage& first, const ViewerOptions& options, Session& session, Panels& panels,
          osgGA::GUIEventHandler* more_keys = nullptr);
  ~Windows();
  Windows(const Windows&) = delete;
  Windows& operator=(const Windows&) = delete;

  // Opens a further window. Throws std::runtime_error where there is none to be had.
  void open();
  std::size_t further() const { return further_.size(); }
  Stage& at(std::size_t i) { return *further_[i].stage; }  // i < further()

  // Draws a picture in each further window, after the first one's. save: receives pictures that their users asked for.
  void draw(const std::function<void(Picture&&)>& save);
  // Does what was asked for by key or from the menu since the last call, in the window where it was, and forgets
  // windows that were closed.
  void obey();

 private:
  struct Window {
    std::unique_ptr<Stage> stage;
    osg::ref_ptr<KeyHandler> keys;
  };
  void obey_in(Stage& in, const std::vector<Request>& requests);
  void open_or_say_why_not();
  void close_in(Stage& in);
  void tell_session();

  Stage& first_;
  const ViewerOptions& options_;
  Session& session_;
  Panels& panels_;
  osg::ref_ptr<osgGA::GUIEventHandler> more_keys_;
  osg::ref_ptr<KeyHandler> first_keys_;
  std::vector<Window> further_;
  int opened_ = 0;  // so far, to tell them apart by their titles
};

}  // namespace palp
