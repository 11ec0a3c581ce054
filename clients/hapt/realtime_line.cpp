// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/hapt/realtime_line.h"

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
  const RealtimeReport report = realtime_of(*servo);
  if ((report.bits & kRealtimeWanted) == 0) {
    return "not real-time here: the session asks for normal priority (session.realtime = false)";
  }
  if (report.first_errno() != 0) return report.explain();
  if (!kernel_is_preempt_rt()) {
    return "not fully real-time here: SCHED_FIFO and locked memory were granted, but the kernel is "
           "not PREEMPT_RT and the host of a virtual machine may still stop it";
  }
  return "real-time: SCHED_FIFO, locked memory, PREEMPT_RT kernel";
}

}  // namespace haptic
