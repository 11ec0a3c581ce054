// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <atomic>
#include <csignal>

/// Orders to test programs (an emulated device, a deliberately faulty process): one small number
/// sent by sigqueue. No process of a session accepts any.
namespace haptic {

namespace detail {
inline std::atomic<int> queued_order{0};
static_assert(std::atomic<int>::is_always_lock_free);  // a signal handler stores it
}  // namespace detail

/// From now on this process accepts orders; before, one would end it.
inline void catch_orders() {
  struct sigaction action {};
  action.sa_sigaction = [](int, siginfo_t* info, void*) {
    detail::queued_order.store(info->si_value.sival_int, std::memory_order_relaxed);
  };
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  sigaction(SIGRTMIN, &action, nullptr);
}

/// The newest order not yet taken; 0: none.
inline int take_order() noexcept {
  return detail::queued_order.exchange(0, std::memory_order_relaxed);
}

/// Sends an order (not 0) to a process that has called catch_orders(); it would end any other.
/// False: no such process, or not permitted.
inline bool send_order(pid_t pid, int order) {
  sigval value{};
  value.sival_int = order;
  return pid > 0 && sigqueue(pid, SIGRTMIN, value) == 0;
}

}  // namespace haptic
