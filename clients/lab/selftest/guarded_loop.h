// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>

#include "clients/lab/selftest/rt_guard.h"
#include "contact/step.h"
#include "device-io/device.h"
#include "proto/config/config.h"
#include "proto/os/realtime.h"

namespace haptic {

/// A device under guard.
struct GuardedDevice {
  std::unique_ptr<Device> device;
  int node = -1;              // descriptor that the loop may read and write; -1: none
  bool is_real_time = false;  // it answers in real time: then all ticks are on the deadline clock
};

/// As haptic-servo opens it; a device with a node lives in real time.
GuardedDevice open_guarded(const DeviceConfig& config);

struct GuardedLoopOptions {
  uint64_t ticks = 1'000'000;                  // guarded, on virtual time, as fast as possible
  uint64_t timed_ticks = 1000;                 // guarded, before those, on the deadline clock
  uint64_t warm_up = 20'000;                   // unguarded, on virtual time, before both
  std::function<void(uint64_t)> also_do = {};  // guarded, after each tick: tests plant defects here
  std::function<GuardedDevice(const DeviceConfig&)> open = open_guarded;
};

struct GuardedLoopResult {
  GuardReport report;
  uint64_t ticks = 0;          // guarded ones
  uint64_t timed_ticks = 0;    // of them, those on the deadline clock
  uint64_t contact_ticks = 0;  // of them, those in contact
  uint64_t lost_ticks = 0;     // of them, those whose device did not answer
  RealtimeReport rights;       // locked memory, or why not

  /// Counts one guarded tick.
  void count(const ServoFrame& frame, bool is_timed) noexcept;
  /// Voluntary context switches beyond one sleep per timed tick.
  uint64_t stray_sleeps() const {
    return report.voluntary_switches - std::min(report.voluntary_switches, timed_ticks);
  }
};

/// True if this device is accessed through a device node.
bool has_node(const DeviceConfig& device);

/// Runs a whole session in one thread under rt_guard: haptic-servo's own loop body with the
/// configured device (in real time it runs at the servo's priority), the rings of four
/// real segments that an attach thread maps read-only, and between the ticks the steps of contact
/// and sim, also guarded. The controls change every few seconds. Locks this process's memory if
/// permitted. Throws std::runtime_error if the hooks are not linked or nothing attaches.
GuardedLoopResult run_guarded_loop(const SessionConfig& config, const ContactShapes& shapes,
                                   const GuardedLoopOptions& options = {});

}  // namespace haptic
