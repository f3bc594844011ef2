// Another window on the OpenGL context of a first one: one context draws into both, so that all it has on the GPU is
// there once, and OSG has one State for it.
#pragma once

#include <string>

#include <osg/ref_ptr>
#include <osgViewer/GraphicsWindow>

namespace palp {

struct WindowPlace {
  int width, height;  // [pixels]
  std::string title;
  int x = 0, y = 0;  // from the upper left corner of the screen [pixels]
};

// Who closes it takes its cameras and its State away first, or OSG gives up what the first window has in the context.
// Its viewer is done when its user closes it.
// first: a window of X11, or one of egl_window.h; it stays usable for as long as the new one is. Off-screen title and
// place count for nothing. Throws std::runtime_error where no such window can be had.
osg::ref_ptr<osgViewer::GraphicsWindow> open_window_beside(osgViewer::GraphicsWindow& first, const WindowPlace& place);

}  // namespace palp
