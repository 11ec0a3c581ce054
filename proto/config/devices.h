// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "proto/config/session_config.h"

namespace haptic {

enum class DeviceKind : uint32_t {
#define DEVICE(id, ...) id,
#include "proto/config/devices.def"
};

struct DeviceRow {
  std::string_view name;  // in a config
  DeviceKind id;
  bool has_node = false;  // hapticd opens it, keeps it, and lets go of it for a servo that is dead;
                          // such a device begins disarmed and lives in real time
  bool can_be_led = false;   // `hapt lead` says where its hand means to go
  bool is_recorded = false;  // the motion is known before: it has an end, and force has no effect
};

/// All devices: config, hapticd, the servo and the lab read this; open_device reads the same lines.
inline constexpr std::array kDevices{
#define DEVICE(id_, name_, open, read, ...) \
  DeviceRow{.name = name_, .id = DeviceKind::id_ __VA_OPT__(, ) __VA_ARGS__},
#include "proto/config/devices.def"
};

constexpr const DeviceRow& row_of(DeviceKind kind) {
  return kDevices[static_cast<size_t>(kind)];
}

/// Path of the device's node; empty: it has none.
inline std::string_view node_of(const DeviceConfig& device) {
  return row_of(device.kind).has_node ? view(device.serial.path) : std::string_view{};
}

/// Replaces the configured device by a recorded hand motion, played back open loop.
inline void use_trace(SessionConfig& config, const std::string& trace) {
  config.device.kind = DeviceKind::kReplay;
  assign(config.device.replay.path, trace);
}

}  // namespace haptic
