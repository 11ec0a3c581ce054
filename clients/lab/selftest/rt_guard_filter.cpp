// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/selftest/rt_guard_filter.h"

#include <seccomp.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <initializer_list>
#include <system_error>

namespace haptic::detail {
namespace {

// always allowed: return from a signal, end of the thread, restart of an interrupted wait
constexpr std::array kAllowed{SCMP_SYS(rt_sigreturn), SCMP_SYS(exit), SCMP_SYS(exit_group),
                              SCMP_SYS(restart_syscall)};
// allowed with the password: lock waits of the C library, printing a stack, aborting
constexpr std::array kOwn{SCMP_SYS(futex),        SCMP_SYS(write),  SCMP_SYS(writev),
                          SCMP_SYS(getpid),       SCMP_SYS(gettid), SCMP_SYS(rt_sigprocmask),
                          SCMP_SYS(rt_sigaction), SCMP_SYS(tgkill)};

// Fifth argument, which the calls above ignore. The value is no valid address: a futex with two
// words fails on it harmlessly.
constexpr unsigned kPasswordPlace = 4;
constexpr uint64_t kPassword = 0x6861'7074'6963'6421;

scmp_arg_cmp equals(unsigned place, uint64_t value) {
  return {place, SCMP_CMP_EQ, value, 0};
}

/// Compares an int argument: the upper half of its register is undefined.
scmp_arg_cmp equals_int(unsigned place, int value) {
  return {place, SCMP_CMP_MASKED_EQ, 0xffff'ffff, static_cast<uint32_t>(value)};
}

void check(int error, const char* what) {
  if (error != 0) throw std::system_error(-error, std::generic_category(), what);
}

void allow(scmp_filter_ctx filter, int call, std::initializer_list<scmp_arg_cmp> where = {}) {
  check(seccomp_rule_add_array(filter, SCMP_ACT_ALLOW, call, static_cast<unsigned>(where.size()),
                               where.begin()),
        "rt_guard: seccomp rule");
}

}  // namespace

SystemCallFilter::SystemCallFilter(int device_node)
    : filter_(seccomp_init(SCMP_ACT_TRAP), seccomp_release) {
  if (filter_ == nullptr) check(-ENOMEM, "rt_guard: seccomp");
  for (const int call : kAllowed) allow(filter_.get(), call);
  for (const int call : kOwn) allow(filter_.get(), call, {equals(kPasswordPlace, kPassword)});
  allow(filter_.get(), SCMP_SYS(clock_nanosleep),
        {equals_int(0, CLOCK_MONOTONIC), equals_int(1, TIMER_ABSTIME)});
  // for the guard's counts
  allow(filter_.get(), SCMP_SYS(getrusage), {equals_int(0, RUSAGE_THREAD)});
  for (const int clock : {CLOCK_MONOTONIC, CLOCK_REALTIME}) {
    allow(filter_.get(), SCMP_SYS(clock_gettime), {equals_int(0, clock)});
  }
  if (device_node < 0) return;
  for (const int call : {SCMP_SYS(read), SCMP_SYS(write)}) {
    allow(filter_.get(), call, {equals_int(0, device_node)});
  }
}

void SystemCallFilter::load() {
  check(seccomp_load(filter_.get()),
        "rt_guard: the kernel refuses a seccomp filter; run outside the sandbox that forbids it");
}

long call_past_filter(long number, long a, long b, long c, long d, long f) noexcept {
  const int errno_before = errno;
  const long made = syscall(number, a, b, c, d, kPassword, f);
  const long result = made == -1 ? -errno : made;
  errno = errno_before;
  return result;
}

#if defined(__x86_64__)

long RefusedCall::number() const noexcept {
  return static_cast<long>(context_.uc_mcontext.gregs[REG_RAX]);
}
long RefusedCall::argument(int i) const noexcept {
  constexpr std::array kPlaces{REG_RDI, REG_RSI, REG_RDX, REG_R10, REG_R8, REG_R9};
  return static_cast<long>(context_.uc_mcontext.gregs[kPlaces[static_cast<size_t>(i)]]);
}
void RefusedCall::set_result(long result) noexcept {
  context_.uc_mcontext.gregs[REG_RAX] = result;
}

#elif defined(__aarch64__)

long RefusedCall::number() const noexcept {
  return static_cast<long>(context_.uc_mcontext.regs[8]);
}
long RefusedCall::argument(int i) const noexcept {
  return static_cast<long>(context_.uc_mcontext.regs[i]);
}
void RefusedCall::set_result(long result) noexcept {
  context_.uc_mcontext.regs[0] = static_cast<unsigned long long>(result);
}

#else
#error "rt_guard: say here which registers hold a system call, its arguments and its result"
#endif

bool RefusedCall::is_lock() const noexcept {
  return number() == SYS_futex;
}

bool RefusedCall::is_abort() const noexcept {
  return number() == SYS_tgkill && argument(2) == SIGABRT;
}

long RefusedCall::make() const noexcept {
  const long call = number();
  if (std::find(kOwn.begin(), kOwn.end(), call) == kOwn.end()) return -ENOSYS;
  return call_past_filter(call, argument(0), argument(1), argument(2), argument(3), argument(5));
}

}  // namespace haptic::detail
