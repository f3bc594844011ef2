#include "haptic_bridge/log/output_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include <fcntl.h>
#include <unistd.h>

namespace palp {

namespace {

namespace fs = std::filesystem;

void make_parent_of(const std::string& what, const std::string& path) {
  std::error_code error;
  const fs::path parent = fs::path(path).parent_path();
  if (!parent.empty()) fs::create_directories(parent, error);
  if (error)
    throw std::runtime_error(fmt::format("{} {}: its directory cannot be made: {}", what, path, error.message()));
}

std::string part_of(const std::string& path) { return path + ".part"; }

}  // namespace

OutputFile::OutputFile(std::string what, const std::string& path)
    : what_(std::move(what) + " " + path), file_(nullptr) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor >= 0) file_ = fdopen(descriptor, "wb");
  if (!file_) fail("cannot be opened for writing");
}

OutputFile::~OutputFile() {
  if (file_) std::fclose(file_);
}

void OutputFile::write(const fmt::memory_buffer& bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail("cannot be written");
}

void OutputFile::reserve(std::size_t bytes) {
  if (ftruncate(fileno(file_), 0) != 0) fail("cannot be emptied");
  if (fallocate(fileno(file_), FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)) == 0) return;
  if (errno == ENOSPC || errno == EDQUOT || errno == EFBIG)
    fail(fmt::format("there is no room for its {} MB", bytes / 1'000'000).c_str());
}

void OutputFile::close() {
  const bool flushed =
      std::fflush(file_) == 0 && ftruncate(fileno(file_), std::ftell(file_)) == 0 && fsync(fileno(file_)) == 0;
  if (!flushed) fail("cannot be written");
  const int closed = std::fclose(file_);
  file_ = nullptr;
  if (closed != 0) fail("cannot be closed");
}

void OutputFile::fail(const char* why) const {
  throw std::runtime_error(fmt::format("{}: {}: {}", what_, why, std::strerror(errno)));
}

void write_whole_file(const std::string& what, const std::string& path,
                      const std::function<void(OutputFile&)>& write_to) {
  make_parent_of(what, path);
  const std::string part = part_of(path);
  OutputFile file(what, part);
  write_to(file);
  file.close();
  std::error_code error;
  fs::rename(part, path, error);
  if (error)
    throw std::runtime_error(fmt::format("{} {}: cannot be renamed from {}: {}", what, path, part, error.message()));
}

ReservedRoom::ReservedRoom(const std::string& what, const std::string& path, std::size_t bytes) : part_(part_of(path)) {
  make_parent_of(what, path);
  try {
    OutputFile(what, part_).reserve(bytes);
  } catch (...) {
    std::error_code ignored;
    fs::remove(part_, ignored);
    throw;
  }
}

ReservedRoom::~ReservedRoom() {
  std::error_code ignored;
  if (fs::file_size(part_, ignored) == 0) fs::remove(part_, ignored);
}

}  // namespace palp
