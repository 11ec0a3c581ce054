// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/realtime_line.h"

#include <sys/utsname.h>

#include <cstring>

namespace haptic {
namespace {

bool kernel_is_preempt_rt() {
  utsname system{};
  return uname(&system) == 0 && std::strstr(system.version, "PREEMPT_RT") != nullptr;
}

}  // namespace

std::string realtime_line(const SegmentHeader* servo) {
  if (servo == nullptr) return "not real-time here: no servo was seen";
  const uint32_t bits = servo->realtime_bits.load();
  const int error = servo->realtime_errno.load();
  if ((bits & kRealtimeWanted) == 0) {
    return "not real-time here: the session asks for normal priority (session.realtime = false)";
  }
  std::string refused;
  if ((bits & kRealtimeFifo) == 0) refused = "SCHED_FIFO";
  if ((bits & kRealtimeMemoryLocked) == 0) {
    refused += refused.empty() ? "locked memory" : " and locked memory";
  }
  if (!refused.empty()) {
    return "not real-time here: " + refused + " refused (" + std::strerror(error) + "); " +
           kMendRealtime;
  }
  if (!kernel_is_preempt_rt()) {
    return "not fully real-time here: SCHED_FIFO and locked memory were granted, but the kernel is "
           "not PREEMPT_RT and the host of a virtual machine may still stop it";
  }
  return "real-time: SCHED_FIFO, locked memory, PREEMPT_RT kernel";
}

}  // namespace haptic
