// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "proto/config/quantity.h"
#include "proto/config/session_config.h"
#include "proto/os/text.h"

namespace haptic {

enum class DeviceKind : uint32_t {
#define DEVICE(id, ...) id,
#include "proto/config/devices.def"
};

/// The node of a device: hapticd opens it, keeps it, and lets go of it for a servo that is dead.
/// Such a device begins disarmed and lives in real time.
enum class NodeKind {
  kNone,
  kSerial,  // a terminal, at the path of [device.serial]
  kHid,     // /dev/hidrawN, found by its ids
  kUsb,     // /dev/bus/usb/BBB/DDD, found by its ids
};

/// 3Dconnexion's devices of six axes, its universal receiver among them. Source: spacenavd.
inline constexpr std::string_view kSpaceMouseIds =
    "046d:c603 046d:c605 046d:c606 046d:c621 046d:c623 046d:c625 046d:c626 046d:c627 046d:c628 "
    "046d:c629 046d:c62b 046d:c640 256f:c62e 256f:c62f 256f:c631 256f:c632 256f:c633 256f:c635 "
    "256f:c636 256f:c638 256f:c63a 256f:c652";
/// Its mice, keyboards and number pads, and two ids on which public drivers disagree.
inline constexpr std::string_view kNoSpaceMouseIds =
    "256f:c62c 256f:c641 256f:c650 256f:c651 256f:c654 256f:c655 256f:c656 256f:c657 256f:c658 "
    "256f:c664 256f:c665 256f:c668";

struct DeviceRow {
  std::string_view name;  // in a config
  DeviceKind id;
  NodeKind node = NodeKind::kNone;
  std::string_view usb_ids{};           // "vvvv:pppp" in hexadecimal, a blank between
  std::string_view usb_product{};       // what the product's name must contain; empty: anything
  std::string_view usb_refused{};       // ids that look like it but are not, for a clear message
  bool tried = false;                   // on hardware; else at an emulated device only
  bool can_be_led = false;              // `hapt lead` says where its hand means to go
  std::string_view simulates = "hand";  // without a node and a recording: what, in words
  // the bodies of [device.gravity], the handle first; none: it has no arm to be held up
  std::array<std::string_view, 1 + kMostLinks> links{};
  bool is_recorded = false;  // the motion is known before: it has an end, and force has no effect

  constexpr bool has_node() const { return node != NodeKind::kNone; }
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

/// Replaces the configured device by a recorded hand motion, played back open loop.
inline void use_trace(SessionConfig& config, const std::string& trace) {
  config.device.kind = DeviceKind::kReplay;
  assign(config.device.replay.path, trace);
}

/// Slower shows a hand at rest, faster no hand can move.
inline constexpr Range kReplaySpeeds{0.1, 4};

/// Options of a replay that override the session file.
struct ReplayChoice {
  std::string trace;                                 // empty: the session file's
  std::optional<double> speed, from, to, stiffness;  // as in ReplayConfig; [N/m]
  bool loop = false, closed_loop = false;

  bool is_any() const {
    return !trace.empty() || speed || from || to || stiffness || loop || closed_loop;
  }
};

/// As hapticd's options, each before its value.
inline std::vector<std::string> replay_options(const ReplayChoice& choice) {
  std::vector<std::string> out;
  const auto add = [&](const char* name, const std::optional<double>& value) {
    if (value) out.insert(out.end(), {name, formatted("%.17g", *value)});
  };
  if (!choice.trace.empty()) out.insert(out.end(), {"--replay", choice.trace});
  add("--replay-speed", choice.speed);
  add("--replay-from", choice.from);
  add("--replay-to", choice.to);
  add("--stiffness", choice.stiffness);
  if (choice.loop) out.emplace_back("--replay-loop");
  if (choice.closed_loop) out.emplace_back("--closed-loop");
  return out;
}
inline std::string replay_words(const ReplayChoice& choice) {
  std::string out;
  for (const std::string& word : replay_options(choice)) out += " " + word;
  return out;
}

inline void use_replay(SessionConfig& config, const ReplayChoice& choice) {
  ReplayConfig& replay = config.device.replay;
  if (!choice.trace.empty()) use_trace(config, choice.trace);
  replay.speed = choice.speed.value_or(replay.speed);
  replay.from = choice.from.value_or(replay.from);
  replay.to = choice.to.value_or(replay.to);
  if (choice.loop) replay.loop = 1;
  if (choice.closed_loop) replay.closed_loop = 1;
  double& stiffness = config.coupling.translational_stiffness;
  stiffness = choice.stiffness.value_or(stiffness);
}

}  // namespace haptic
