// A test waits for what others do.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace palp::test {

// Looks again and again until it is done or the time is up; returns whether it was done.
inline bool eventually(const std::function<bool()>& done, std::chrono::milliseconds limit = std::chrono::seconds(10)) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace palp::test
