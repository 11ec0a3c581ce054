// SPDX-License-Identifier: Apache-2.0
#include "proto/rt_guard.h"

#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <seccomp.h>
#include <sys/resource.h>
#include <ucontext.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <system_error>

namespace haptic {
namespace {

constexpr std::array<const char*, kViolations> kNames{"allocation",  "free",       "mutex",
                                                      "condition",   "rwlock",     "system call",
                                                      "minor fault", "major fault"};

// what the servo's loop may ask of the kernel, and what the guard itself needs
constexpr std::array kAllowedCalls{
    SCMP_SYS(clock_nanosleep), SCMP_SYS(clock_gettime), SCMP_SYS(getrusage),
    SCMP_SYS(rt_sigreturn),    SCMP_SYS(exit),          SCMP_SYS(exit_group)};
// to print a stack and abort
constexpr std::array kCallsToAbort{
    SCMP_SYS(write),  SCMP_SYS(writev),         SCMP_SYS(getpid),       SCMP_SYS(gettid),
    SCMP_SYS(tgkill), SCMP_SYS(rt_sigprocmask), SCMP_SYS(rt_sigaction), SCMP_SYS(restart_syscall)};

// constinit: a thread's first look at them runs no code
constinit thread_local bool is_armed = false;
constinit thread_local bool aborts = false;
constinit thread_local GuardReport* current = nullptr;
constinit bool hooks_linked = false;

void abort_loudly(Violation kind, const Caught& caught) noexcept {
  constexpr std::array<const char*, 2> kAround{"rt_guard: the armed loop did: ", "\n"};
  const std::string_view text = kNames[static_cast<size_t>(kind)];
  ssize_t unused = write(STDERR_FILENO, kAround[0], std::string_view(kAround[0]).size());
  unused += write(STDERR_FILENO, text.data(), text.size());
  unused += write(STDERR_FILENO, kAround[1], 1);
  static_cast<void>(unused);
  backtrace_symbols_fd(caught.stack.data(), caught.depth, STDERR_FILENO);
  std::abort();
}

void count(Violation kind, uint64_t times = 1) noexcept {
  Caught& caught = current->of(kind);
  if (caught.count == 0) caught.depth = backtrace(caught.stack.data(), Caught::kMaxDepth);
  caught.count += times;
  if (aborts) abort_loudly(kind, caught);
}

/// The call was not made. Its result must be set, or the caller takes what the register held.
void on_refused_call(int, siginfo_t* info, void* context) {
  auto& registers = static_cast<ucontext_t*>(context)->uc_mcontext;
#if defined(__x86_64__)
  registers.gregs[REG_RAX] = -ENOSYS;
#elif defined(__aarch64__)
  registers.regs[0] = static_cast<unsigned long long>(-ENOSYS);
#else
#error "rt_guard: say here which register holds the result of a system call"
#endif
  if (!is_armed) return;
  is_armed = false;
  if (current->first_system_call < 0) current->first_system_call = info->si_syscall;
  count(Violation::kSystemCall);
  is_armed = true;
}

void allow(scmp_filter_ctx filter, int call) {
  const int error = seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 0);
  if (error != 0) throw std::system_error(-error, std::generic_category(), "seccomp rule");
}

/// Of the calling thread, for the rest of its life.
void filter_system_calls(bool may_abort) {
  struct sigaction action {};
  action.sa_sigaction = on_refused_call;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSYS, &action, nullptr);

  const std::unique_ptr<void, void (*)(scmp_filter_ctx)> filter(seccomp_init(SCMP_ACT_TRAP),
                                                                seccomp_release);
  if (filter == nullptr) throw std::system_error(ENOMEM, std::generic_category(), "seccomp");
  for (const int call : kAllowedCalls) allow(filter.get(), call);
  if (may_abort) {
    for (const int call : kCallsToAbort) allow(filter.get(), call);
  }
  const int error = seccomp_load(filter.get());
  if (error != 0) {
    throw std::system_error(-error, std::generic_category(),
                            "rt_guard: the kernel refuses a seccomp filter; run outside the "
                            "sandbox that forbids it");
  }
}

/// Name of the function an address lies in, or of its file.
std::string function_at(void* address) {
  Dl_info info{};
  if (dladdr(address, &info) == 0) return "?";
  if (info.dli_sname == nullptr) return info.dli_fname != nullptr ? info.dli_fname : "?";
  int status = 0;
  const std::unique_ptr<char, void (*)(void*)> plain(
      abi::__cxa_demangle(info.dli_sname, nullptr, nullptr, &status), std::free);
  return status == 0 ? plain.get() : info.dli_sname;
}

}  // namespace

namespace detail {

void note_violation(Violation kind) noexcept {
  if (!is_armed) return;
  // what counting itself does is not the loop's
  is_armed = false;
  count(kind);
  is_armed = true;
}

void note_hooks_linked() noexcept {
  hooks_linked = true;
}

}  // namespace detail

const char* name_of(Violation kind) noexcept {
  return kNames[static_cast<size_t>(kind)];
}

bool guard_hooks_linked() noexcept {
  return hooks_linked;
}

uint64_t GuardReport::violations() const noexcept {
  uint64_t sum = 0;
  for (const Caught& c : caught) sum += c.count;
  return sum;
}

std::string GuardReport::explain() const {
  std::string text;
  for (size_t kind = 0; kind < kViolations; ++kind) {
    if (caught[kind].count == 0) continue;
    text += std::string(kNames[kind]) + " × " + std::to_string(caught[kind].count);
    if (static_cast<Violation>(kind) == Violation::kSystemCall) {
      const std::unique_ptr<char, void (*)(void*)> call(
          seccomp_syscall_resolve_num_arch(SCMP_ARCH_NATIVE, first_system_call), std::free);
      text += std::string(" (") + (call != nullptr ? call.get() : "unknown") + ")";
    }
    for (int i = 0; i < caught[kind].depth; ++i) {
      text += (i == 0 ? ": " : " < ") + function_at(caught[kind].stack[static_cast<size_t>(i)]);
    }
    text += '\n';
  }
  return text;
}

RtGuard::RtGuard(const GuardOptions& options) {
  // the first backtrace loads a library, the first getrusage touches pages
  std::array<void*, 4> warm_up{};
  backtrace(warm_up.data(), static_cast<int>(warm_up.size()));
  read_usage();
  current = &report_;
  aborts = options.abort_at_once;
  if (options.filter_system_calls) filter_system_calls(options.abort_at_once);
}

RtGuard::~RtGuard() {
  is_armed = false;
  current = nullptr;
}

RtGuard::Usage RtGuard::read_usage() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {usage.ru_minflt, usage.ru_majflt, usage.ru_nivcsw, usage.ru_nvcsw};
}

void RtGuard::arm() noexcept {
  armed_at_ = read_usage();
  is_armed = true;
}

void RtGuard::disarm() noexcept {
  is_armed = false;
  const Usage now = read_usage();
  const auto minor = static_cast<uint64_t>(now.minor_faults - armed_at_.minor_faults);
  const auto major = static_cast<uint64_t>(now.major_faults - armed_at_.major_faults);
  report_.of(Violation::kMinorFault).count += minor;
  report_.of(Violation::kMajorFault).count += major;
  report_.involuntary_switches +=
      static_cast<uint64_t>(now.involuntary_switches - armed_at_.involuntary_switches);
  report_.voluntary_switches +=
      static_cast<uint64_t>(now.voluntary_switches - armed_at_.voluntary_switches);
  if (!aborts || minor + major == 0) return;
  const Violation kind = major > 0 ? Violation::kMajorFault : Violation::kMinorFault;
  abort_loudly(kind, report_.of(kind));
}

}  // namespace haptic
