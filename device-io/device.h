// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "proto/config/config.h"
#include "proto/os/file_descriptor.h"
#include "proto/wire/wire.h"

namespace haptic {

/// What a device can do, in its own units.
struct DeviceCaps {
  double max_force = 0;    // [N]
  double max_torque = 0;   // [N·m]; 0: no torque actuators
  bool open_loop = false;  // the wrench has no effect on the motion
  bool simulated = false;
};

/// Both instants on one clock: CLOCK_MONOTONIC, or virtual time in lockstep.
struct TickTime {
  int64_t deadline_ns;  // the grid point this tick belongs to
  int64_t now_ns;       // when it really woke
};

/// The one virtual interface of the project. Opening is the constructor's work and may throw and
/// block; after that no call allocates, throws, locks or takes unbounded time.
class Device {
 public:
  virtual ~Device() = default;

  virtual DeviceCaps caps() const = 0;

  /// One line for people: what it is, and what a recording is resampled by.
  virtual std::string description() const = 0;

  /// Fills in the state at this tick. False when nothing new could be read: the state is then the
  /// previous one with kDeviceHeld set instead of kDeviceFresh.
  virtual bool read(const TickTime& tick, DeviceState& state) = 0;

  /// Holds this wrench (on the handle at its origin, in B) until the next write.
  virtual void write(const Wrench& F_B) = 0;

  /// Zero wrench, whatever came before. Idempotent; called on every way out. May wait for the
  /// device to confirm it, 40 ms at most.
  virtual void stop() = 0;

  /// The same from outside of the process, by whoever holds the node open.
  virtual DeviceRelease release() const { return {}; }
};

/// Opens the device the config names; where it has a node, `node` is that node already open (by
/// hapticd, which keeps a duplicate), or none: it is opened here. Throws std::runtime_error with a
/// one-line remedy.
std::unique_ptr<Device> open_device(const DeviceConfig& config, FileDescriptor node = {});

}  // namespace haptic
