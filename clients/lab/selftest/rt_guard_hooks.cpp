// SPDX-License-Identifier: GPL-3.0-or-later
// Interposed libc functions that a real-time loop must not call: each notifies rt_guard, then calls
// the original. An object linked into the tests and hapt-lab, never into a process of a session.
#include "clients/lab/selftest/rt_guard.h"

// sanitizers interpose the same functions
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>
#include <threads.h>
#include <time.h>

#include <atomic>
#include <bit>
#include <cerrno>
#include <cstdlib>

// glibc's own names of the interposed functions
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* memory, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
void* __libc_valloc(size_t size);
void* __libc_pvalloc(size_t size);
void __libc_free(void* memory);
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

namespace {

using haptic::Violation;
using haptic::detail::note_violation;

/// The original of an interposed function, looked up at the first call. No guarded static, which
/// may lock.
class Original {
 public:
  constexpr Original(const char* name, const char* version) : name_(name), version_(version) {}

  template <typename... Arguments>
  int operator()(Arguments... arguments) {
    void* found = function_.load(std::memory_order_relaxed);
    if (found == nullptr) {
      // without a version dlsym may find the condition variables of 1999
      if (version_ != nullptr) found = dlvsym(RTLD_NEXT, name_, version_);
      if (found == nullptr) found = dlsym(RTLD_NEXT, name_);
      if (found == nullptr) return ENOSYS;
      function_.store(found, std::memory_order_relaxed);
    }
    return reinterpret_cast<int (*)(Arguments...)>(found)(arguments...);
  }

 private:
  const char* name_;
  const char* version_;
  std::atomic<void*> function_{nullptr};
};

#if defined(__x86_64__)
constexpr const char* kConditionVersion = "GLIBC_2.3.2";
#else
constexpr const char* kConditionVersion = nullptr;
#endif

[[gnu::constructor]] void tell_that_hooks_are_here() {
  haptic::detail::note_hooks_linked();
}

}  // namespace

extern "C" {

void* malloc(size_t size) noexcept {
  note_violation(Violation::kAllocate);
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) noexcept {
  note_violation(Violation::kAllocate);
  return __libc_calloc(count, size);
}
void* realloc(void* memory, size_t size) noexcept {
  note_violation(Violation::kAllocate);
  return __libc_realloc(memory, size);
}
void* memalign(size_t alignment, size_t size) noexcept {
  note_violation(Violation::kAllocate);
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(size_t alignment, size_t size) noexcept {
  note_violation(Violation::kAllocate);
  return __libc_memalign(alignment, size);
}
void* valloc(size_t size) noexcept {
  note_violation(Violation::kAllocate);
  return __libc_valloc(size);
}
void* pvalloc(size_t size) noexcept {
  note_violation(Violation::kAllocate);
  return __libc_pvalloc(size);
}
int posix_memalign(void** memory, size_t alignment, size_t size) noexcept {
  note_violation(Violation::kAllocate);
  if (!std::has_single_bit(alignment) || alignment % sizeof(void*) != 0) return EINVAL;
  void* found = __libc_memalign(alignment, size);
  if (found == nullptr) return ENOMEM;
  *memory = found;
  return 0;
}
void free(void* memory) noexcept {
  // free(nullptr) does nothing
  if (memory != nullptr) note_violation(Violation::kFree);
  __libc_free(memory);
}

// a libc function: kind of violation, version, name, parameters, arguments of the call
#define HAPTIC_HOOK(kind, version, name, parameters, arguments) \
  int name parameters noexcept(noexcept(name arguments)) {      \
    static constinit Original original{#name, version};         \
    note_violation(Violation::kind);                            \
    return original arguments;                                  \
  }

using Mutex = pthread_mutex_t;
using Condition = pthread_cond_t;
using Rwlock = pthread_rwlock_t;
using Time = const timespec;
using Spin = pthread_spinlock_t;

HAPTIC_HOOK(kMutex, nullptr, pthread_mutex_lock, (Mutex * m), (m))
HAPTIC_HOOK(kMutex, nullptr, pthread_mutex_trylock, (Mutex * m), (m))
HAPTIC_HOOK(kMutex, nullptr, pthread_mutex_timedlock, (Mutex * m, Time* t), (m, t))
HAPTIC_HOOK(kMutex, nullptr, pthread_mutex_clocklock, (Mutex * m, clockid_t c, Time* t), (m, c, t))
HAPTIC_HOOK(kMutex, nullptr, mtx_lock, (mtx_t * m), (m))
HAPTIC_HOOK(kMutex, nullptr, mtx_trylock, (mtx_t * m), (m))
HAPTIC_HOOK(kMutex, nullptr, mtx_timedlock, (mtx_t * m, Time* t), (m, t))
HAPTIC_HOOK(kMutex, nullptr, pthread_spin_lock, (Spin * s), (s))
HAPTIC_HOOK(kMutex, nullptr, pthread_spin_trylock, (Spin * s), (s))
HAPTIC_HOOK(kMutex, nullptr, sem_wait, (sem_t * s), (s))
HAPTIC_HOOK(kMutex, nullptr, sem_trywait, (sem_t * s), (s))
HAPTIC_HOOK(kMutex, nullptr, sem_timedwait, (sem_t * s, Time* t), (s, t))
HAPTIC_HOOK(kMutex, nullptr, sem_clockwait, (sem_t * s, clockid_t c, Time* t), (s, c, t))
HAPTIC_HOOK(kCondition, kConditionVersion, pthread_cond_wait, (Condition * c, Mutex* m), (c, m))
HAPTIC_HOOK(kCondition, kConditionVersion, pthread_cond_timedwait,
            (Condition * c, Mutex* m, Time* t), (c, m, t))
HAPTIC_HOOK(kCondition, nullptr, pthread_cond_clockwait,
            (Condition * c, Mutex* m, clockid_t k, Time* t), (c, m, k, t))
HAPTIC_HOOK(kCondition, kConditionVersion, pthread_cond_signal, (Condition * c), (c))
HAPTIC_HOOK(kCondition, kConditionVersion, pthread_cond_broadcast, (Condition * c), (c))
HAPTIC_HOOK(kRwlock, nullptr, pthread_rwlock_rdlock, (Rwlock * l), (l))
HAPTIC_HOOK(kRwlock, nullptr, pthread_rwlock_wrlock, (Rwlock * l), (l))
HAPTIC_HOOK(kRwlock, nullptr, pthread_rwlock_tryrdlock, (Rwlock * l), (l))
HAPTIC_HOOK(kRwlock, nullptr, pthread_rwlock_trywrlock, (Rwlock * l), (l))
HAPTIC_HOOK(kRwlock, nullptr, pthread_rwlock_timedrdlock, (Rwlock * l, Time* t), (l, t))
HAPTIC_HOOK(kRwlock, nullptr, pthread_rwlock_timedwrlock, (Rwlock * l, Time* t), (l, t))
HAPTIC_HOOK(kRwlock, nullptr, pthread_rwlock_clockrdlock, (Rwlock * l, clockid_t c, Time* t),
            (l, c, t))
HAPTIC_HOOK(kRwlock, nullptr, pthread_rwlock_clockwrlock, (Rwlock * l, clockid_t c, Time* t),
            (l, c, t))

}  // extern "C"

#endif
