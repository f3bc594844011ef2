// A disk that is soon full.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <sys/mount.h>

namespace palp::test {

// A disk of so many megabytes, if this test may make one. there: it could.
class SmallDisk {
 public:
  SmallDisk(std::filesystem::path at, int megabytes) : path(std::move(at)) {
    std::filesystem::create_directories(path);
    there = mount("tmpfs", path.c_str(), "tmpfs", 0, ("size=" + std::to_string(megabytes) + "m").c_str()) == 0;
  }
  ~SmallDisk() {
    if (there) umount(path.c_str());
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  void fill() const {
    std::ofstream file(path / "others");
    while (file << std::string(4096, 'x') << std::flush) {
    }
  }

  std::filesystem::path path;
  bool there = false;
};

}  // namespace palp::test
