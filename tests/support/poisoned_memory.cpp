// Fills memory that is aligned beyond the ordinary, as the CPU back end's arrays are, with the bits of numbers that are
// not finite: what a simulation reads before it has written it shows in every test of a binary that links this file.
#include <cstdlib>
#include <cstring>
#include <new>

void* operator new(std::size_t size, std::align_val_t align) {
  const auto unit = static_cast<std::size_t>(align);
  const std::size_t bytes = (size + unit - 1) / unit * unit;
  void* p = std::aligned_alloc(unit, bytes);
  if (p == nullptr) throw std::bad_alloc();
  std::memset(p, 0xff, bytes);
  return p;
}

void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
