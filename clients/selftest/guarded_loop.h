// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>

#include "contact/step.h"
#include "proto/config/config.h"
#include "proto/os/realtime.h"
#include "proto/os/rt_guard.h"

namespace haptic {

struct GuardedLoopOptions {
  uint64_t ticks = 1'000'000;   // armed, on virtual time, as fast as they go
  uint64_t timed_ticks = 1000;  // armed, before them, on the deadline clock
  uint64_t warm_up = 20'000;    // unarmed, on virtual time, before both
  // what has a node lives in real time: then all of them are on the deadline clock
  std::function<void(uint64_t)> also_do = {};  // armed, after each tick: where tests plant
};

struct GuardedLoopResult {
  GuardReport report;
  uint64_t ticks = 0;          // armed ones
  uint64_t timed_ticks = 0;    // of them, those that waited for the deadline clock
  uint64_t contact_ticks = 0;  // of them, those that touched
  uint64_t lost_ticks = 0;     // of them, those whose device did not answer
  RealtimeReport rights;       // locked memory, or why not

  /// One more armed tick.
  void count(const ServoFrame& frame, bool is_timed) noexcept;
  /// Times the thread gave the processor away beyond one sleep a timed tick.
  uint64_t stray_sleeps() const {
    return report.voluntary_switches - std::min(report.voluntary_switches, timed_ticks);
  }
};

/// Whether this device lies behind a node.
bool has_node(const DeviceConfig& device);

/// A whole session in one thread under rt_guard: haptic-servo's own loop body with the config's
/// device (a node may be read and written, at the servo's priority), the rings of four real
/// segments that an attach thread maps read-only, and between the ticks the steps of contact and
/// sim, armed as well; the controls change every few seconds. Locks this process's memory meanwhile
/// where that is allowed. Throws std::runtime_error where the hooks are not linked or nothing
/// attaches.
GuardedLoopResult run_guarded_loop(const SessionConfig& config, const ContactShapes& shapes,
                                   const GuardedLoopOptions& options = {});

}  // namespace haptic
