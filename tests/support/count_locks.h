// Counts the locks that a thread takes and the times that it waits, wherever in the process the code stands. Not under
// the thread and address sanitizers, which take these functions for themselves: there nothing is counted.
#pragma once

#include <cstdint>

namespace palp::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kCountsLocks = false;
#else
inline constexpr bool kCountsLocks = true;
#endif

// By the calling thread, from start to stop: mutexes, read-write locks and spin locks that it took or tried, condition
// variables, semaphores, barriers, threads and one-time initialisations that it waited for.
void start_counting_locks();
std::uint64_t stop_counting_locks();

}  // namespace palp::test
