// Files that the devices read: each test writes its own.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "config/error.h"
#include "tests/support/files.h"

namespace palp::test {

class DeviceFiles : public ::testing::Test {
 protected:
  // Writes the one file of this test and returns its path.
  std::string write(const std::string& text) {
    const std::string file = folder_ / "file";
    write_text(file, text);
    return file;
  }
  ScratchFolder folder_;
};

// Returns the fault that reading finds.
template <class F>
std::string fault_of(F&& read) {
  try {
    read();
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "no fault";
}

}  // namespace palp::test
