// A CSV file being written. Every failure to write is an error with the file's name, never silence. Not for real time.
#pragma once

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace palp {

class CsvFile {
 public:
  // Creates or empties the file and writes the header. Throws std::runtime_error.
  CsvFile(const std::string& path, const std::vector<std::string>& columns);
  // Numbers with 9 significant digits; nothing gives an empty cell. Throws when the disk is full.
  void row(const std::vector<std::optional<double>>& cells);
  // Appends text that the caller has formatted as whole rows.
  void append(const std::string& rows);
  // Writes what is buffered. A file that is not closed may lack its last rows. Throws like row().
  void close();
  const std::string& path() const { return path_; }

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[noreturn]] void fail() const;
  void write(const std::string& text);

  std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;
  std::string line_;
};

// Makes the folder and those above it. Throws std::runtime_error.
void make_folder(const std::string& path);

}  // namespace palp
