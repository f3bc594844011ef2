#include "config/csv_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <stdexcept>

namespace palp {

CsvFile::CsvFile(const std::string& path, const std::vector<std::string>& columns)
    : path_(path), file_(std::fopen(path.c_str(), "w")) {
  if (!file_) fail();
  std::string header;
  for (const std::string& column : columns) header += (header.empty() ? "" : ",") + column;
  write(header + "\n");
}

void CsvFile::fail() const {
  const int error = errno;
  throw std::runtime_error(fmt::format("{}: cannot write: {}", path_, error ? std::strerror(error) : "unknown error"));
}

void CsvFile::write(const std::string& text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) fail();
}

void CsvFile::row(const std::vector<std::optional<double>>& cells) {
  line_.clear();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) line_ += ',';
    if (cells[i]) fmt::format_to(std::back_inserter(line_), "{:.9g}", *cells[i]);
  }
  line_ += '\n';
  write(line_);
}

void CsvFile::append(const std::string& rows) { write(rows); }

void CsvFile::close() {
  if (!file_) return;
  errno = 0;
  if (std::fflush(file_.get()) != 0) fail();
  errno = 0;
  if (std::fclose(file_.release()) != 0) fail();
}

void make_folder(const std::string& path) {
  if (path.empty()) throw std::runtime_error("the name of the folder for results is empty, expected a path");
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error || !std::filesystem::is_directory(path, error)) {
    throw std::runtime_error(
        fmt::format("{}: cannot make the folder: {}", path, error ? error.message() : "it is a file"));
  }
}

}  // namespace palp
