#include "idl/frame_ring.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "idl/clock.h"
#include "idl/validate.h"

namespace palp {
namespace {

constexpr const char* kPrefix = "palp-frames-";
constexpr std::size_t kPage = 4096;
static_assert(sizeof(RingHeader) <= kPage);
constexpr off_t kOwnersByte = 0, kReadersByte = 1;

std::size_t to_pages(std::size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

struct Offsets {
  std::size_t header, positions, scalars, solid;
};
Offsets offsets_of(std::size_t slot, std::uint32_t particle_count) {
  const std::size_t n = particle_count, header = slot_begin(slot, particle_count);
  const std::size_t positions = header + sizeof(SlotHeader), scalars = positions + 3 * sizeof(float) * n;
  return {header, positions, scalars, scalars + sizeof(float) * n};
}

// Moves all bytes by pread or pwrite, or returns false.
template <class Call, class Byte>
bool move_all(Call call, const RingFile& file, std::size_t at, Byte* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t n = call(file.number(), bytes, count, static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes += n, at += static_cast<std::size_t>(n), count -= static_cast<std::size_t>(n);
  }
  return true;
}
bool put(const RingFile& file, std::size_t at, const void* data, std::size_t bytes) {
  return move_all(pwrite, file, at, static_cast<const char*>(data), bytes);
}
bool get(const RingFile& file, std::size_t at, void* data, std::size_t bytes) {
  return move_all(pread, file, at, static_cast<char*>(data), bytes);
}

constexpr std::size_t kNewestAt = offsetof(RingHeader, newest);
constexpr std::size_t begun_at(std::size_t slot) { return offsetof(RingHeader, begun) + slot * sizeof(std::uint64_t); }

// A number that is read while it is written may be neither the old nor the new one: such a one is of no frame, and the
// comparison that follows finds that out.
std::uint64_t number_at(const RingFile& file, std::size_t at) {
  std::uint64_t number = 0;
  return get(file, at, &number, sizeof number) ? number : kRingClosed;
}
bool set_number(const RingFile& file, std::size_t at, std::uint64_t number) {
  return put(file, at, &number, sizeof number);
}

struct flock lock_of(short type, off_t byte) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = byte;
  lock.l_len = 1;
  return lock;
}
bool lock(const RingFile& file, short type, off_t byte) {
  struct flock wanted = lock_of(type, byte);
  return fcntl(file.number(), F_OFD_SETLK, &wanted) == 0;
}
// Returns whether another open file holds a lock that this one would have to wait for.
bool is_locked(const RingFile& file, short type, off_t byte) {
  struct flock wanted = lock_of(type, byte);
  return fcntl(file.number(), F_OFD_GETLK, &wanted) == 0 && wanted.l_type != F_UNLCK;
}

RingFile open_to_read(const std::string& path) {
  return RingFile(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
}
bool is_own_file(const RingFile& file, struct stat& status) {
  return fstat(file.number(), &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == geteuid();
}

void remove_left_behind(const std::string& folder) {
  std::error_code none;
  for (std::filesystem::directory_iterator entry(folder, none), end; !none && entry != end; entry.increment(none)) {
    if (!entry->path().filename().string().starts_with(kPrefix)) continue;
    const RingFile file = open_to_read(entry->path());
    struct stat status {};
    if (file.number() < 0 || !is_own_file(file, status) || is_locked(file, F_RDLCK, kOwnersByte)) continue;
    unlink(entry->path().c_str());
  }
}

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error("shared memory " + path + " " + what);
}

}  // namespace

std::string path_of(const RingPlace& place) {
  return place.folder + "/" + kPrefix + std::to_string(kRingLayout) + "-" + std::to_string(place.domain) + "-" +
         std::to_string(place.session);
}

std::size_t slot_begin(std::size_t slot, std::uint32_t particle_count) {
  return kPage + slot * to_pages(sizeof(SlotHeader) + (4 * sizeof(float) + 1) * std::size_t{particle_count});
}

RingFile::RingFile(RingFile&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
RingFile& RingFile::operator=(RingFile&& other) noexcept {
  std::swap(file_, other.file_);
  return *this;
}
RingFile::~RingFile() {
  if (file_ >= 0) close(file_);
}

// The file gets its name last, so that nobody meets one that is half made or without its owner's lock.
FrameRingWriter::FrameRingWriter(const RingPlace& place) : place_(place) {
  const std::string path = path_of(place);
  remove_left_behind(place.folder);
  file_ = RingFile(open(place.folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600));
  if (file_.number() < 0) fail(path, std::string("cannot be made: ") + std::strerror(errno));
  RingHeader header;
  header.domain = static_cast<std::uint64_t>(place.domain);
  header.session = place.session;
  header.particle_count = place.particle_count;
  const std::string self = "/proc/self/fd/" + std::to_string(file_.number());
  const auto size = static_cast<off_t>(slot_begin(kRingSlots, place.particle_count));
  if (ftruncate(file_.number(), size) != 0 || !put(file_, 0, &header, sizeof header) ||
      !lock(file_, F_WRLCK, kOwnersByte) ||
      linkat(AT_FDCWD, self.c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) != 0)
    fail(path, std::string("cannot be made: ") + std::strerror(errno));
}

FrameRingWriter::~FrameRingWriter() { unlink(path_of(place_).c_str()); }

bool FrameRingWriter::close_ring() {
  set_number(file_, kNewestAt, kRingClosed);
  written_ = kRingClosed;
  return false;
}

bool FrameRingWriter::has_readers() const { return is_locked(file_, F_WRLCK, kReadersByte); }

bool FrameRingWriter::write(const ParticleFrame& f) {
  const std::size_t n = place_.particle_count;
  const bool fits = f.positions.size() == 3 * n && f.scalars.size() == (f.field == ScalarField::none ? 0 : n) &&
                    (f.solid.empty() || f.solid.size() == n);
  if (written_ == kRingClosed || !fits) return close_ring();
  const std::uint64_t number = written_ + 1;
  const std::size_t slot = number % kRingSlots;
  const Offsets at = offsets_of(slot, place_.particle_count);
  const SlotHeader header{f.frame, f.sim_time, now_ns(), static_cast<std::uint32_t>(f.field), !f.solid.empty()};
  if (!set_number(file_, begun_at(slot), number)) return close_ring();
  std::atomic_thread_fence(std::memory_order_seq_cst);
  if (!put(file_, at.header, &header, sizeof header) ||
      !put(file_, at.positions, f.positions.data(), sizeof(float) * f.positions.size()) ||
      !put(file_, at.scalars, f.scalars.data(), sizeof(float) * f.scalars.size()) ||
      !put(file_, at.solid, f.solid.data(), f.solid.size()))
    return close_ring();
  std::atomic_thread_fence(std::memory_order_seq_cst);
  written_ = number;
  return set_number(file_, kNewestAt, number) || close_ring();
}

FrameRingReader::FrameRingReader(const RingPlace& place) : place_(place), file_(open_to_read(path_of(place))) {
  const std::string path = path_of(place);
  if (file_.number() < 0) fail(path, std::string("cannot be opened: ") + std::strerror(errno));
  struct stat status {};
  if (!is_own_file(file_, status)) fail(path, "is no file of this user");
  RingHeader header, expected;
  const bool sound = static_cast<std::size_t>(status.st_size) >= slot_begin(kRingSlots, place.particle_count) &&
                     get(file_, 0, &header, sizeof header) && header.magic == expected.magic &&
                     header.layout == expected.layout && header.domain == static_cast<std::uint64_t>(place.domain) &&
                     header.session == place.session && header.particle_count == place.particle_count;
  if (!sound) fail(path, "is not the ring of frames of this server: its size or its first page is another");
  if (header.newest == kRingClosed) fail(path, "has been closed");
  if (!lock(file_, F_RDLCK, kReadersByte)) fail(path, std::string("cannot be shared: ") + std::strerror(errno));
  // a frame that was written for a reader of long ago would be shown as new
  taken_ = number_at(file_, kNewestAt);
}

RingAnswer FrameRingReader::take(ParticleFrame& out) {
  constexpr int kTries = 3;  // a reader that is kept from its work for two frames starts again with the newest
  for (int k = 0; k < kTries; ++k) {
    const std::uint64_t newest = number_at(file_, kNewestAt);
    if (newest == kRingClosed) return RingAnswer::closed;
    if (newest == taken_ || newest == 0) return RingAnswer::nothing;
    std::atomic_thread_fence(std::memory_order_seq_cst);
    const bool sound = copy_slot(newest, out);
    std::atomic_thread_fence(std::memory_order_seq_cst);
    if (number_at(file_, begun_at(newest % kRingSlots)) != newest) continue;
    taken_ = newest;
    return sound && validate(out) == Fault::none ? RingAnswer::frame : RingAnswer::refused;
  }
  return RingAnswer::nothing;
}

bool FrameRingReader::copy_slot(std::uint64_t number, ParticleFrame& out) const {
  const std::size_t n = place_.particle_count;
  const Offsets at = offsets_of(number % kRingSlots, place_.particle_count);
  SlotHeader header;
  if (!get(file_, at.header, &header, sizeof header)) return false;
  if (header.field >= kScalarFields.size() || header.with_solid > 1) return false;
  out.frame = header.frame;
  out.sim_time = header.sim_time;
  out.field = static_cast<ScalarField>(header.field);
  out.session = place_.session;
  out.t_send_ns = header.t_send_ns;
  out.positions.resize(3 * n);
  out.scalars.resize(out.field == ScalarField::none ? 0 : n);
  out.solid.resize(header.with_solid == 1 ? n : 0);
  const bool whole = get(file_, at.positions, out.positions.data(), sizeof(float) * out.positions.size()) &&
                     get(file_, at.scalars, out.scalars.data(), sizeof(float) * out.scalars.size()) &&
                     get(file_, at.solid, out.solid.data(), out.solid.size());
  out.t_receive_ns = now_ns();
  return whole;
}

}  // namespace palp
