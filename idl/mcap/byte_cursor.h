// Reads numbers, strings and maps from bytes that nobody vouches for: every length is checked before it is used.
#pragma once

#include <map>
#include <string>

#include "idl/mcap/mcap_format.h"

namespace palp {

class ByteCursor {
 public:
  // `where` opens every error: the file and what is being read. `base`: the byte offset of bytes[0] in it.
  ByteCursor(ByteView bytes, std::string where, std::uint64_t base)
      : bytes_(bytes), where_(std::move(where)), base_(base) {}

  std::size_t left() const { return bytes_.size() - at_; }
  std::size_t at() const { return at_; }
  std::uint64_t offset() const { return base_ + at_; }

  [[noreturn]] void fail(const std::string& what) const {
    throw McapError(where_ + ": at byte " + std::to_string(offset()) + ": " + what);
  }

  // All throw McapError when the bytes end too early.
  template <class T>
  T get() {
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }
  ByteView take(std::uint64_t n) {
    if (n > left()) fail("needs " + std::to_string(n) + " bytes where " + std::to_string(left()) + " are left");
    const ByteView view = bytes_.subspan(at_, static_cast<std::size_t>(n));
    at_ += static_cast<std::size_t>(n);
    return view;
  }
  std::string string() {
    const ByteView view = take(get<std::uint32_t>());
    return {view.begin(), view.end()};
  }
  // Bytes that open with their length in 32 bits.
  ByteCursor sub() {
    const auto n = get<std::uint32_t>();
    const std::uint64_t begin = offset();
    return {take(n), where_, begin};
  }
  std::map<std::string, std::string> string_map() {
    std::map<std::string, std::string> out;
    ByteCursor entries = sub();
    while (entries.left() > 0) {
      std::string key = entries.string();
      out[std::move(key)] = entries.string();
    }
    return out;
  }
  std::map<std::uint16_t, std::uint64_t> number_map() {
    std::map<std::uint16_t, std::uint64_t> out;
    ByteCursor entries = sub();
    while (entries.left() > 0) {
      const auto key = entries.get<std::uint16_t>();
      out[key] = entries.get<std::uint64_t>();
    }
    return out;
  }

 private:
  ByteView bytes_;
  std::size_t at_ = 0;
  std::string where_;
  std::uint64_t base_;
};

}  // namespace palp
