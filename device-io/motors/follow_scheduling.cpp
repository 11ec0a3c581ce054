// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/motors/follow_scheduling.h"

#include <sched.h>

#include "proto/os/realtime.h"

namespace haptic {

void follow_scheduling_of(pthread_t other) {
  int policy = SCHED_OTHER;
  sched_param parameters{};
  if (pthread_getschedparam(other, &policy, &parameters) != 0) return;
  if ((policy & ~SCHED_RESET_ON_FORK) != SCHED_FIFO) return;
  enter_realtime({.fifo_priority = parameters.sched_priority + 1, .lock_memory = false});
}

}  // namespace haptic
