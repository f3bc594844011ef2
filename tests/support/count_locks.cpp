// The functions of the C library by which anything in the process locks or waits, each counted and handed on.
#include "tests/support/count_locks.h"

#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>

namespace {
thread_local bool t_counting = false;
thread_local std::uint64_t t_locks = 0;
}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

// For a function of the C library that returns int: its parameters and, to call it, their names.
// NOLINTBEGIN(bugprone-macro-parentheses): these are lists
#define PALP_COUNTED(function, parameters, arguments)                                           \
  extern "C" int function parameters {                                                          \
    if (t_counting) ++t_locks;                                                                  \
    static const auto kNext = reinterpret_cast<int(*) parameters>(dlsym(RTLD_NEXT, #function)); \
    return kNext arguments;                                                                     \
  }
// NOLINTEND(bugprone-macro-parentheses)

PALP_COUNTED(pthread_mutex_lock, (pthread_mutex_t * m), (m))
PALP_COUNTED(pthread_mutex_trylock, (pthread_mutex_t * m), (m))
PALP_COUNTED(pthread_mutex_timedlock, (pthread_mutex_t * m, const timespec* t), (m, t))
PALP_COUNTED(pthread_mutex_clocklock, (pthread_mutex_t * m, clockid_t c, const timespec* t), (m, c, t))
PALP_COUNTED(pthread_rwlock_rdlock, (pthread_rwlock_t * l), (l))
PALP_COUNTED(pthread_rwlock_wrlock, (pthread_rwlock_t * l), (l))
PALP_COUNTED(pthread_rwlock_tryrdlock, (pthread_rwlock_t * l), (l))
PALP_COUNTED(pthread_rwlock_trywrlock, (pthread_rwlock_t * l), (l))
PALP_COUNTED(pthread_spin_lock, (pthread_spinlock_t * l), (l))
PALP_COUNTED(pthread_spin_trylock, (pthread_spinlock_t * l), (l))
PALP_COUNTED(pthread_cond_wait, (pthread_cond_t * c, pthread_mutex_t* m), (c, m))
PALP_COUNTED(pthread_cond_timedwait, (pthread_cond_t * c, pthread_mutex_t* m, const timespec* t), (c, m, t))
PALP_COUNTED(pthread_cond_clockwait, (pthread_cond_t * c, pthread_mutex_t* m, clockid_t k, const timespec* t),
             (c, m, k, t))
PALP_COUNTED(pthread_barrier_wait, (pthread_barrier_t * b), (b))
PALP_COUNTED(pthread_once, (pthread_once_t * o, void (*f)()), (o, f))
PALP_COUNTED(pthread_join, (pthread_t t, void** r), (t, r))
PALP_COUNTED(sem_wait, (sem_t * s), (s))
PALP_COUNTED(sem_timedwait, (sem_t * s, const timespec* t), (s, t))
PALP_COUNTED(sem_clockwait, (sem_t * s, clockid_t c, const timespec* t), (s, c, t))
#undef PALP_COUNTED

#endif

namespace palp::test {

void start_counting_locks() {
  t_locks = 0;
  t_counting = true;
}

std::uint64_t stop_counting_locks() {
  t_counting = false;
  return t_locks;
}

}  // namespace palp::test
