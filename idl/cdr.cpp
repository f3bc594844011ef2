#include "idl/cdr.h"

#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <type_traits>

#include "idl/fields.h"

namespace palp {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they stand");

constexpr std::size_t kEncapsulation = 4;  // bytes; alignment counts from behind them

// The type that a field has on the wire: enumerations travel as unsigned long, booleans as one byte.
template <class T>
using OnWire =
    std::conditional_t<std::is_enum_v<T>, std::uint32_t, std::conditional_t<std::is_same_v<T, bool>, std::uint8_t, T>>;

template <class T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

// Values of these types stand in memory as on the wire.
template <class T>
concept Copied = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

class Put {
 public:
  std::vector<std::uint8_t> bytes{0, 1, 0, 0};

  template <Plain T>
  void field(const T& value) {
    const auto wire = static_cast<OnWire<T>>(value);
    align(sizeof wire);
    append(&wire, sizeof wire);
  }
  void field(const std::string& text) {
    field(static_cast<std::uint32_t>(text.size() + 1));
    append(text.c_str(), text.size() + 1);
  }
  template <class T, std::size_t n>
  void field(const std::array<T, n>& values) {
    for (const T& value : values) field(value);
  }
  template <class T>
  void field(const std::vector<T>& values) {
    field(static_cast<std::uint32_t>(values.size()));
    if constexpr (Copied<T>) {
      if (values.empty()) return;
      align(sizeof(T));
      append(values.data(), sizeof(T) * values.size());
    } else {
      for (const T& value : values) field(value);
    }
  }
  template <class T>
  requires std::is_class_v<T>
  void field(const T& part) { fields_of(*this, part); }
  template <class T>
  void derived(const T& value) {
    field(value);
  }
  // The payload ends on a multiple of 4; the options of the header say how many bytes were added.
  void finish() {
    const std::size_t padding = (4 - bytes.size() % 4) % 4;
    bytes.resize(bytes.size() + padding);
    bytes[3] = static_cast<std::uint8_t>(padding);
  }

// NOLINTBEGIN(bugprone-macro-parentheses): T is a type
#define PALP_FIELD(name) put.field(m.name);
#define PALP_RENAMED(name, wire_name) put.field(m.name);
#define PALP_DERIVED(wire_name, value) put.derived(value);
#define PALP_PUT(T) \
  friend void fields_of(Put& put, const T& m) { PALP_FIELDS_OF_##T(PALP_FIELD, PALP_RENAMED, PALP_DERIVED) }
  PALP_FOR_EACH_PART(PALP_PUT)
  PALP_FOR_EACH_MESSAGE(PALP_PUT)
#undef PALP_FIELD
#undef PALP_RENAMED
#undef PALP_DERIVED
#undef PALP_PUT

 private:
  void align(std::size_t size) { bytes.resize(bytes.size() + (size - (bytes.size() - kEncapsulation) % size) % size); }
  void append(const void* from, std::size_t size) {
    const auto* begin = static_cast<const std::uint8_t*>(from);
    bytes.insert(bytes.end(), begin, begin + size);
  }
};

// Reads until something does not fit; from then on nothing changes any more.
class Take {
 public:
  explicit Take(std::span<const std::uint8_t> payload) : bytes_(payload) {
    good_ = bytes_.size() >= kEncapsulation && bytes_[0] == 0 && bytes_[1] == 1;
  }

  template <Plain T>
  void field(T& value) {
    OnWire<T> wire{};
    align(sizeof wire);
    copy(&wire, sizeof wire);
    if (good_) value = static_cast<T>(wire);
  }
  void field(std::string& text) {
    const std::size_t size = length(1);
    if (!good_ || size == 0 || bytes_[at_ + size - 1] != 0) {
      good_ = false;
      return;
    }
    text.assign(reinterpret_cast<const char*>(bytes_.data() + at_), size - 1);
    at_ += size;
  }
  template <class T, std::size_t n>
  void field(std::array<T, n>& values) {
    for (T& value : values) field(value);
  }
  template <class T>
  void field(std::vector<T>& values) {
    // no element is shorter than a byte, so that memory grows with what is there and not with what is claimed
    const std::size_t size = length(Copied<T> ? sizeof(T) : 1);
    values.clear();
    if (!good_ || size == 0) return;
    if constexpr (Copied<T>) {
      align(sizeof(T));
      values.resize(size);
      copy(values.data(), sizeof(T) * size);
    } else {
      for (std::size_t i = 0; i < size && good_; ++i) field(values.emplace_back());
    }
  }
  template <class T>
  requires std::is_class_v<T>
  void field(T& part) { fields_of(*this, part); }
  template <class T>
  void derived(const T&) {
    T known{};
    field(known);
  }
  // Returns whether all was read and no more than padding is left.
  bool complete() const { return good_ && bytes_.size() - at_ < 4; }

#define PALP_FIELD(name) take.field(m.name);
#define PALP_RENAMED(name, wire_name) take.field(m.name);
#define PALP_DERIVED(wire_name, value) take.derived(value);
#define PALP_TAKE(T) \
  friend void fields_of(Take& take, T& m) { PALP_FIELDS_OF_##T(PALP_FIELD, PALP_RENAMED, PALP_DERIVED) }
  PALP_FOR_EACH_PART(PALP_TAKE)
  PALP_FOR_EACH_MESSAGE(PALP_TAKE)
#undef PALP_FIELD
#undef PALP_RENAMED
#undef PALP_DERIVED
#undef PALP_TAKE
  // NOLINTEND(bugprone-macro-parentheses)

 private:
  void align(std::size_t size) {
    const std::size_t gap = (size - (at_ - kEncapsulation) % size) % size;
    good_ = good_ && gap <= bytes_.size() - at_;
    if (good_) at_ += gap;
  }
  void copy(void* to, std::size_t size) {
    good_ = good_ && size <= bytes_.size() - at_;
    if (!good_) return;
    std::memcpy(to, bytes_.data() + at_, size);
    at_ += size;
  }
  // Reads a number of elements that are at least so long.
  std::size_t length(std::size_t element) {
    std::uint32_t size = 0;
    field(size);
    good_ = good_ && size <= (bytes_.size() - at_) / element;
    return good_ ? size : 0;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = kEncapsulation;
  bool good_ = true;
};

template <class T>
std::vector<std::uint8_t> encode(const T& m) {
  Put put;
  put.field(m);
  put.finish();
  return std::move(put.bytes);
}

template <class T>
Fault decode(std::span<const std::uint8_t> payload, T& out) {
  out.header = {};
  Take take(payload);
  take.field(out);
  // of another version only the header can be read
  if (!take.complete()) return out.header.version != kProtocolVersion ? Fault::wrong_version : Fault::malformed;
  return validate(out);
}

}  // namespace

// NOLINTBEGIN(bugprone-macro-parentheses): T is a type
#define PALP_CDR(T)                                                  \
  std::vector<std::uint8_t> to_cdr(const T& m) { return encode(m); } \
  Fault from_cdr(std::span<const std::uint8_t> payload, T& out) { return decode(payload, out); }
PALP_FOR_EACH_MESSAGE(PALP_CDR)
#undef PALP_CDR
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace palp
