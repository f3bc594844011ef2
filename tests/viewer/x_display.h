// An X server without a screen, and what a window manager would do in it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/files.h"
#include "tests/support/process.h"

namespace palp::test {

class XDisplay {
 public:
  // Starts Xvfb, where there is one.
  XDisplay();
  ~XDisplay();
  bool open() const { return connection_ != nullptr; }
  std::string name() const { return name_; }  // for DISPLAY

  // Returns the window of that title, if it is there.
  std::optional<unsigned long> window(const std::string& title) const;
  void place(unsigned long window, int x, int y, int width, int height);
  // Returns width and height [pixels].
  std::pair<int, int> size(unsigned long window) const;
  void press(unsigned long window, char letter);
  // Asks the window's program to close it, as the button in its frame does.
  void close(unsigned long window);
  // Returns how many of its pixels are red by far.
  int red_pixels(unsigned long window) const;

 private:
  ScratchFolder folder_;
  std::unique_ptr<ChildProcess> server_;
  std::string name_;
  void* connection_ = nullptr;
};

}  // namespace palp::test
