// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "proto/config/config.h"
#include "proto/os/file_descriptor.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The direction of cause and effect at a device's port (Adams, Hannaford 1999).
enum class Causality {
  kImpedance,   // measures the pose, is commanded a wrench
  kAdmittance,  // measures the hand's wrench, is commanded a pose
};

/// Abilities of a device, in its own units.
struct DeviceCaps {
  double max_force = 0;    // [N]
  double max_torque = 0;   // [N·m]; 0: no torque actuators
  bool open_loop = false;  // the wrench has no effect on the motion
  bool simulated = false;
  bool is_planar = false;  // it moves in the plane z = 0 of B
  Causality causality = Causality::kImpedance;
};

/// Silence after which a device counts as lost until it answers again [ns]
/// (docs/decisions/0004-a-device-may-be-silent-for-20-ms.md).
inline constexpr int64_t kDeviceSilenceNs = 20'000'000;

/// Two instants on one clock: CLOCK_MONOTONIC, or virtual time in lockstep.
struct TickTime {
  int64_t deadline_ns;  // grid point of this tick
  int64_t now_ns;       // actual wake-up
};

/// A device's zero force as these bytes, at most 64; for kUsbBulk the interface and the endpoint.
DeviceRelease release_by(ReleaseBy by, std::span<const uint8_t> bytes, uint32_t interface = 0,
                         uint32_t endpoint = 0);

/// Hears a piece of what a device and its driver say to each other: a report or a packet, and the
/// instant that the driver takes for that of the piece.
using HearBytes = std::function<void(bool by_device, std::span<const uint8_t> bytes, int64_t t_ns)>;

/// A haptic device. Its constructor opens it and may throw and block; after that no call allocates,
/// throws, locks or takes unbounded time.
class Device {
 public:
  virtual ~Device() = default;

  virtual DeviceCaps caps() const = 0;

  /// One line: what the device is, and how a recording is resampled.
  virtual std::string description() const = 0;

  /// Reads the state at this tick. False if there is nothing new: `state` is then the previous one
  /// with kDeviceHeld instead of kDeviceFresh.
  virtual bool read(const TickTime& tick, DeviceState& state) = 0;

  /// Commands this wrench (on the handle at its origin, in B) until the next write.
  virtual void write(const Wrench& F_B) = 0;

  /// Commands an admittance device to reach this pose of the handle in B one tick from now, where
  /// it rests until the next command. Others are never asked.
  virtual void move(const Pose& /*X_BH*/) {}

  /// The wrench on the handle that holds up arm and handle where the last read found them, by these
  /// masses. Zero: it has no arm, or is where none can be known.
  virtual Wrench holding(const GravityConfig& /*gravity*/) const { return {}; }

  /// Commands a zero wrench, or to rest where it is. Idempotent; called whenever the loop ends. May
  /// wait at most 40 ms for the device's confirmation.
  virtual void stop() = 0;

  /// Leads the intention of the hand from now on: pose of the handle in B; none: where it means to
  /// go by itself. Only a simulated hand can be led; others go where a person moves them.
  virtual void lead(const std::optional<Pose>& /*X_BH*/) {}

  /// From now on `hears` is told all that is said, on whichever thread says it, as long as this
  /// lives: for somebody who tries a device out, since it may allocate. At most once. False: this
  /// driver does not; a serial line is recorded at its node.
  virtual bool tap(HearBytes /*hears*/) { return false; }

  /// The bytes that command zero when written to the node by another process; empty: there is no
  /// node.
  virtual DeviceRelease release() const { return {}; }
};

/// Opens a device of one kind, on its node if that is open. Throws std::runtime_error.
using OpenDevice = std::unique_ptr<Device>(const DeviceConfig& config, FileDescriptor node);

/// Opens the configured device, by its line in proto/config/devices.def. `node` is its node if
/// already open (by hapticd, which keeps a duplicate), else it is opened here. Throws
/// std::runtime_error: one line with a remedy.
std::unique_ptr<Device> open_device(const DeviceConfig& config, FileDescriptor node = {});

}  // namespace haptic
