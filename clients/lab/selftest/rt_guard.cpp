// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/selftest/rt_guard.h"

#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <seccomp.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <utility>

#include "clients/lab/selftest/rt_guard_filter.h"

namespace haptic {
namespace {

constexpr std::array<const char*, kViolations> kNames{"allocation",  "free",       "mutex",
                                                      "condition",   "rwlock",     "system call",
                                                      "minor fault", "major fault"};

// constinit: no initialisation code at a thread's first access
constinit thread_local bool is_armed = false;
constinit thread_local bool aborts = false;
constinit thread_local bool is_ending = false;
constinit thread_local GuardReport* current = nullptr;
constinit bool hooks_linked = false;

struct PageFaults {
  long minor = 0, major = 0;
};
constinit thread_local PageFaults own_faults{};  // caused by the guard itself since it was armed

rusage usage_of_thread() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage;
}

/// The caller's stack. The unwinder's tables may be touched for the first time: those faults are
/// not the loop's.
int read_stack(std::array<void*, Caught::kMaxDepth>& stack) noexcept {
  const rusage before = usage_of_thread();
  const int depth = backtrace(stack.data(), Caught::kMaxDepth);
  const rusage after = usage_of_thread();
  own_faults.minor += after.ru_minflt - before.ru_minflt;
  own_faults.major += after.ru_majflt - before.ru_majflt;
  return depth;
}

void say(std::string_view text) noexcept {
  detail::call_past_filter(SYS_write, STDERR_FILENO, reinterpret_cast<intptr_t>(text.data()),
                           static_cast<long>(text.size()));
}

[[noreturn]] void abort_loudly(std::string_view what) noexcept {
  is_armed = false;
  is_ending = true;
  say("rt_guard: the guarded loop did: ");
  say(what);
  say("\n");
  std::array<void*, Caught::kMaxDepth> stack;
  backtrace_symbols_fd(stack.data(), backtrace(stack.data(), Caught::kMaxDepth), STDERR_FILENO);
  std::abort();
}

void count(Violation kind) noexcept {
  Caught& caught = current->of(kind);
  if (caught.count == 0) caught.depth = read_stack(caught.stack);
  ++caught.count;
  if (aborts) abort_loudly(name_of(kind));
}

/// Refused calls count armed or not: they change what the thread does.
void note_refused(const detail::RefusedCall& call, bool was_armed) noexcept {
  if (current == nullptr || (call.is_lock() && !was_armed)) return;
  if (current->first_system_call < 0) current->first_system_call = static_cast<int>(call.number());
  count(Violation::kSystemCall);
}

/// Tells the caller that the call failed. But a failing lock would end the program without a
/// message, so a wait for one is counted and then made.
void on_refused_call(int, siginfo_t*, void* context) {
  detail::RefusedCall call(context);
  if (is_ending) return call.set_result(call.make());
  const bool was_armed = std::exchange(is_armed, false);
  if (call.is_abort()) abort_loudly("abort");
  note_refused(call, was_armed);
  call.set_result(call.is_lock() ? call.make() : -ENOSYS);
  is_armed = was_armed;
}

void handle_refused_calls() {
  struct sigaction action {};
  action.sa_sigaction = on_refused_call;
  // nested: printing a stack makes calls that are refused
  action.sa_flags = SA_SIGINFO | SA_NODEFER;
  sigaction(SIGSYS, &action, nullptr);
}

/// Name of the function at an address, or of its file.
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
  // the guard's own actions do not count
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
  // warm-up: the first backtrace loads a library, the first getrusage touches pages
  std::array<void*, 4> warm_up{};
  backtrace(warm_up.data(), static_cast<int>(warm_up.size()));
  usage_of_thread();
  current = &report_;
  aborts = options.abort_at_once;
  if (!options.filter_system_calls) return;
  handle_refused_calls();
  filter_ = std::make_unique<detail::SystemCallFilter>(options.device_node);
}

RtGuard::~RtGuard() {
  is_armed = false;
  current = nullptr;
}

void RtGuard::arm() {
  // only now: a warm-up must behave as without a guard
  if (filter_ && !std::exchange(is_filtered_, true)) filter_->load();
  own_faults = {};
  armed_at_ = usage_of_thread();
  is_armed = true;
}

void RtGuard::disarm() noexcept {
  is_armed = false;
  const rusage now = usage_of_thread();
  const auto minor = static_cast<uint64_t>(now.ru_minflt - armed_at_.ru_minflt - own_faults.minor);
  const auto major = static_cast<uint64_t>(now.ru_majflt - armed_at_.ru_majflt - own_faults.major);
  report_.of(Violation::kMinorFault).count += minor;
  report_.of(Violation::kMajorFault).count += major;
  report_.involuntary_switches += static_cast<uint64_t>(now.ru_nivcsw - armed_at_.ru_nivcsw);
  report_.voluntary_switches += static_cast<uint64_t>(now.ru_nvcsw - armed_at_.ru_nvcsw);
  if (!aborts || minor + major == 0) return;
  abort_loudly(name_of(major > 0 ? Violation::kMajorFault : Violation::kMinorFault));
}

}  // namespace haptic
