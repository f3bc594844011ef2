// Files that are either whole or not there.
#pragma once

#include <cstdio>
#include <functional>
#include <string>

#include <fmt/format.h>

namespace palp {

// Closes itself; fails loudly, with std::runtime_error of one sentence that begins with `what`, when the disk does.
class OutputFile {
 public:
  OutputFile(std::string what, const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(const fmt::memory_buffer& bytes);
  void close();  // it is on the disk then

 private:
  [[noreturn]] void fail(const char* why) const;
  std::string what_;
  std::FILE* file_;
};

// Writes to a file beside the path and renames it: the path holds either all of it or what was there before. Missing
// directories are made. Throws std::runtime_error with one sentence that begins with `what` and the path.
void write_whole_file(const std::string& what, const std::string& path,
                      const std::function<void(OutputFile&)>& write_to);
// Makes the directories of the path and tries to write there. Throws as write_whole_file.
void check_writable(const std::string& what, const std::string& path);

}  // namespace palp
