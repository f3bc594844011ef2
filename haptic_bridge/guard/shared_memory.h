// Plain data that a process forked later sees, too, and still has when this one is killed.
#pragma once

#include <cstddef>
#include <new>

#include <sys/mman.h>

namespace palp {

// A fixed number of T, made by default and never destroyed: T holds no memory of its own. Its pages are there from the
// start.
template <class T>
class SharedArray {
 public:
  // Throws std::bad_alloc.
  explicit SharedArray(std::size_t size) : size_(size) {
    void* memory = mmap(nullptr, bytes(), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    first_ = static_cast<T*>(memory);
    for (std::size_t i = 0; i < size; ++i) new (first_ + i) T;
  }
  ~SharedArray() { munmap(first_, bytes()); }
  SharedArray(const SharedArray&) = delete;
  SharedArray& operator=(const SharedArray&) = delete;

  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return first_[i]; }
  const T& operator[](std::size_t i) const { return first_[i]; }

 private:
  std::size_t bytes() const { return size_ * sizeof(T); }

  T* first_;
  std::size_t size_;
};

}  // namespace palp
