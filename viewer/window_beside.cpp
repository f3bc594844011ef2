#include "viewer/window_beside.h"

#include <stdexcept>
#include <string_view>

#include <osg/State>

#include "viewer/egl_window.h"

// behind all others: X11 has macros by the names of much
#include <osgViewer/api/X11/GraphicsWindowX11>

namespace palp {
namespace {

using X11Window = osgViewer::GraphicsWindowX11;

// A window whose pictures the first one's context draws.
class X11WindowBeside : public X11Window {
 public:
  X11WindowBeside(X11Window& first, osg::GraphicsContext::Traits* traits) : X11Window(traits), first_(&first) {
    if (!_valid) return;
    glXDestroyContext(_display, _context);  // its own
    _context = nullptr;
    const unsigned id = getState()->getContextID();
    setState(first.getState());
    decrementContextIDUsageCount(id);
  }

  bool valid() const override { return X11Window::valid() && first_->valid(); }
  // GLX knows the window by its number, whoever made it; contexts belong to the connection that made them.
  bool makeCurrentImplementation() override {
    return _realized && valid() && glXMakeCurrent(first_->getDisplay(), _window, first_->getContext()) == True;
  }
  bool releaseContextImplementation() override {
    return first_->valid() && glXMakeCurrent(first_->getDisplay(), 0, nullptr) == True;
  }
  void swapBuffersImplementation() override {
    if (!_realized || !valid()) return;
    glXSwapBuffers(first_->getDisplay(), _window);
    for (XEvent event; XPending(_display) > 0;) {
      XNextEvent(_display, &event);
      if (event.type == ClientMessage && static_cast<Atom>(event.xclient.data.l[0]) == _deleteWindow)
        getEventQueue()->quitApplication();  // of its own viewer, which does not close it by itself
    }
  }
  // The first one's pictures wait for the screen; waiting here, too, would halve their rate.
  void never_wait_for_screen() {
    const char* extensions = glXQueryExtensionsString(first_->getDisplay(), static_cast<int>(_traits->screenNum));
    if (extensions == nullptr || std::string_view(extensions).find("GLX_EXT_swap_control") == std::string_view::npos)
      return;
    using SetInterval = void (*)(Display*, GLXDrawable, int);
    const auto set =
        reinterpret_cast<SetInterval>(glXGetProcAddress(reinterpret_cast<const GLubyte*>("glXSwapIntervalEXT")));
    if (set != nullptr) set(first_->getDisplay(), _window, 0);
  }

 private:
  osg::ref_ptr<X11Window> first_;
};

}  // namespace

osg::ref_ptr<osgViewer::GraphicsWindow> open_window_beside(osgViewer::GraphicsWindow& first, const WindowPlace& place) {
  if (auto surface = make_egl_window_beside(first, place.width, place.height)) return surface;
  auto* x11 = dynamic_cast<X11Window*>(&first);
  if (x11 == nullptr || !x11->valid()) throw std::runtime_error("cannot open a window beside one that is not open");
  // the same visual, which is what lets the context draw into it
  osg::ref_ptr<osg::GraphicsContext::Traits> traits = new osg::GraphicsContext::Traits(*first.getTraits());
  traits->x = place.x;
  traits->y = place.y;
  traits->width = place.width;
  traits->height = place.height;
  traits->windowName = place.title;
  traits->windowDecoration = true;
  osg::ref_ptr<X11WindowBeside> window = new X11WindowBeside(*x11, traits);
  if (!window->valid()) throw std::runtime_error("cannot open another window on DISPLAY");
  window->never_wait_for_screen();
  return window;
}

}  // namespace palp
