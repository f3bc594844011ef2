// Files that are either whole or not there.
#pragma once

#include <cstdio>
#include <functional>
#include <string>

#include <fmt/format.h>

namespace palp {

// Closes itself; fails loudly, with std::runtime_error of one sentence that begins with `what`, when the disk does.
// Room that was reserved for it stays reserved until it is closed.
class OutputFile {
 public:
  OutputFile(std::string what, const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(const fmt::memory_buffer& bytes);
  void reserve(std::size_t bytes);  // empties it; takes the room where the file system can
  void close();                     // it is on the disk then, and no longer than what was written

 private:
  [[noreturn]] void fail(const char* why) const;
  std::string what_;
  std::FILE* file_;
};

// Writes to PATH.part and renames that: the path holds either all of it or what was there before. Missing directories
// are made. Throws std::runtime_error with one sentence that begins with `what` and the path (disk full, no
// permission); what could be written stays in PATH.part.
void write_whole_file(const std::string& what, const std::string& path,
                      const std::function<void(OutputFile&)>& write_to);

// Room on the disk for write_whole_file, taken before a run: it does not find out at its end that it cannot write
// there, and a disk that fills meanwhile costs nothing. Where the file system cannot reserve, only the path is tried.
class ReservedRoom {
 public:
  // Makes the directories of the path and, empty but with its room, PATH.part. Throws as write_whole_file.
  ReservedRoom(const std::string& what, const std::string& path, std::size_t bytes);
  ~ReservedRoom();  // gives back what was not used
  ReservedRoom(const ReservedRoom&) = delete;
  ReservedRoom& operator=(const ReservedRoom&) = delete;

 private:
  std::string part_;
};

}  // namespace palp
