// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/motors/transfer_thread.h"

#include <sched.h>
#include <time.h>

#include "proto/math/units.h"
#include "proto/os/realtime.h"

namespace haptic {

void TransferThread::stop() const {
  const uint64_t before = sent_.load(std::memory_order_acquire);
  const timespec turn{0, kMs};
  for (int64_t waited_ns = 0; waited_ns < kStopNs; waited_ns += kMs) {
    // one may have been under way with the command before
    if (mailbox_.is_gone() || sent_.load(std::memory_order_acquire) >= before + 2) return;
    nanosleep(&turn, nullptr);
  }
}

void TransferThread::tap(HearBytes hears) {
  hears_ = std::move(hears);
  is_tapped_.store(true, std::memory_order_release);
}

void TransferThread::end() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
}

void TransferThread::follow_servo() {
  if (follows_ || !mailbox_.command_at(now_ns())) return;
  follows_ = true;
  int policy = SCHED_OTHER;
  sched_param parameters{};
  if (pthread_getschedparam(servo_, &policy, &parameters) != 0) return;
  if ((policy & ~SCHED_RESET_ON_FORK) != SCHED_FIFO) return;
  enter_realtime({.fifo_priority = parameters.sched_priority + 1, .lock_memory = false});
}

}  // namespace haptic
