#include "tests/viewer/x_display.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstring>

#include "tests/support/eventually.h"

// behind all others: it has macros by the names of much
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/keysym.h>

namespace palp::test {
namespace {

::Display* display_of(void* connection) { return static_cast<::Display*>(connection); }

// Windows come and go between two questions.
int pass_over(::Display* /*unused*/, XErrorEvent* /*unused*/) { return 0; }

}  // namespace

XDisplay::XDisplay() {
  try {
    server_ = std::make_unique<ChildProcess>(
        std::vector<std::string>{"Xvfb", "-displayfd", "1", "-screen", "0", "1280x1024x24", "-nolisten", "tcp"},
        folder_ / "xvfb");
  } catch (const std::runtime_error&) {
    return;  // there is none here
  }
  const auto number = [this] {
    std::string text = server_->output();
    const std::size_t end = text.find('\n');
    const bool whole = end != std::string::npos && end > 0 &&
                       std::all_of(text.begin(), text.begin() + static_cast<long>(end),
                                   [](unsigned char c) { return std::isdigit(c); });
    return whole ? text.substr(0, end) : std::string();
  };
  if (!eventually([&] { return !number().empty(); }, std::chrono::seconds(10))) return;
  name_ = ":" + number();
  XSetErrorHandler(pass_over);
  connection_ = XOpenDisplay(name_.c_str());
}

XDisplay::~XDisplay() {
  if (connection_ != nullptr) XCloseDisplay(display_of(connection_));
  if (server_) server_->stop();
}

std::optional<unsigned long> XDisplay::window(const std::string& title) const {
  ::Display* display = display_of(connection_);
  Window root = 0, parent = 0, *children = nullptr;
  unsigned count = 0;
  std::optional<unsigned long> found;
  XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count);
  for (unsigned i = 0; i < count; ++i) {
    char* name = nullptr;
    if (XFetchName(display, children[i], &name) != 0 && name != nullptr && title == name) found = children[i];
    if (name != nullptr) XFree(name);
  }
  if (children != nullptr) XFree(children);
  return found;
}

void XDisplay::place(unsigned long window, int x, int y, int width, int height) {
  XMoveResizeWindow(display_of(connection_), window, x, y, static_cast<unsigned>(width), static_cast<unsigned>(height));
  XSync(display_of(connection_), 0);
}

std::pair<int, int> XDisplay::size(unsigned long window) const {
  XWindowAttributes attributes{};
  XGetWindowAttributes(display_of(connection_), window, &attributes);
  return {attributes.width, attributes.height};
}

void XDisplay::press(unsigned long window, char letter) {
  ::Display* display = display_of(connection_);
  for (const int type : {KeyPress, KeyRelease}) {
    XEvent event{};
    event.xkey.type = type;
    event.xkey.window = window;
    event.xkey.root = DefaultRootWindow(display);
    event.xkey.same_screen = 1;
    event.xkey.keycode = XKeysymToKeycode(display, static_cast<KeySym>(letter));
    XSendEvent(display, window, 0, type == KeyPress ? KeyPressMask : KeyReleaseMask, &event);
  }
  XSync(display, 0);
}

void XDisplay::close(unsigned long window) {
  ::Display* display = display_of(connection_);
  XEvent event{};
  event.xclient.type = ClientMessage;
  event.xclient.window = window;
  event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", 0);
  event.xclient.format = 32;
  event.xclient.data.l[0] = static_cast<long>(XInternAtom(display, "WM_DELETE_WINDOW", 0));
  XSendEvent(display, window, 0, NoEventMask, &event);
  XSync(display, 0);
}

int XDisplay::red_pixels(unsigned long window) const {
  const auto [width, height] = size(window);
  XImage* image = XGetImage(display_of(connection_), window, 0, 0, static_cast<unsigned>(width),
                            static_cast<unsigned>(height), AllPlanes, ZPixmap);
  if (image == nullptr) return -1;
  int count = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const unsigned long pixel = XGetPixel(image, x, y);
      const unsigned long r = pixel >> 16 & 0xff, g = pixel >> 8 & 0xff, b = pixel & 0xff;
      count += r > 76 && 10 * r > 18 * std::max(g, b);
    }
  }
  XDestroyImage(image);
  return count;
}

}  // namespace palp::test
