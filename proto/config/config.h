// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <type_traits>

#include "proto/config/config_names.h"
#include "proto/config/device_config.h"
#include "proto/config/renderer_config.h"
#include "proto/config/scene_config.h"
#include "proto/wire/mapping.h"
#include "proto/wire/wire.h"

namespace haptic {

/// How the servo waits for the next tick.
enum class Wake : uint32_t { kSleep = 0, kHybrid = 1 };

struct CouplingConfig {
  double translational_stiffness = 800;  // [N/m], scene units
  double translational_damping = 0;      // [N·s/m]
  double rotational_stiffness = 0;       // [N·m/rad]
  double rotational_damping = 0;         // [N·m·s/rad]
  double max_force = 0;                  // of the spring on a 6-DoF proxy; 0: no bound [N]
  double max_torque = 0;                 // likewise [N·m]; 0: no bound
};

struct SafetyConfig {
  double max_force = 6;          // [N], device units; the device's own limit applies too
  double max_torque = 0.1;       // [N·m]
  double soft_start = 0.5;       // ramp after start, fault and re-seeding [s]
  double slew = 2000;            // of a force that grows without motion of the hand [N/s]
  double velocity_limit = 2;     // of the handle [m/s]
  int32_t dead_man_button = -1;  // bit that must be held; −1: none
  uint32_t armed_at_start = 1;   // 0: waits for `hapt arm`, the default of a real device
};

/// A parsed and checked session. Trivially copyable: hapticd parses the file once and hands a copy
/// to every process it starts, in a sealed memfd.
struct SessionConfig {
  Name name{};
  Path file{};                      // path of the session file
  double servo_rate = 1000;         // [Hz]
  double contact_poll_rate = 4000;  // how often contact looks again for a late ServoFrame [Hz]
  double sim_rate = 120;            // [Hz]
  uint64_t mesh_memory_limit = uint64_t{4} << 30;  // limit while a mesh is baked [bytes]
  uint32_t realtime = 1;                           // 0: no real-time priority or locked memory
  Renderer renderer{};
  double proxy_radius = 1e-3;  // of virtual-proxy3; 0: a point [m]
  VoxelConfig voxel;
  RigidConfig rigid;
  ToolConfig tool;
  ProxyConfig proxy;
  DeviceMap map;
  DeviceConfig device;
  CouplingConfig coupling;
  SafetyConfig safety;
  uint32_t n_objects = 0;
  Wake servo_wake = Wake::kSleep;
  std::array<ObjectConfig, kMaxObjects> objects{};
  uint32_t n_images = 0;
  uint32_t contact_spare = 1;  // 0: no spare contact process
  std::array<HeightImage, kMaxImages> images{};
};
static_assert(std::is_trivially_copyable_v<SessionConfig>);

/// Reads, checks and resolves a TOML session file. Quantities are strings with a unit ("800 N/m",
/// "2 mm", "1 kHz"); relative paths are relative to the folder of the file. Throws ConfigError.
SessionConfig load_config(const std::string& path);

/// Parses text; `origin` is the path in messages and the base of relative paths.
SessionConfig parse_config(std::string_view toml_text, const std::string& origin);

/// Longest session file [bytes]: four times our longest, and more than a scene full of objects
/// needs. The TOML parser recurses per nested table, with 270 bytes of stack for two bytes of text
/// ("a."): at most 4.4 MB of the usual 8. hapticd sends the text in one message of the control
/// socket.
inline constexpr size_t kMostConfigText = size_t{32} << 10;

/// The unchanged text of a session file, for recordings. Throws ConfigError.
std::string read_config_text(const std::string& path);

}  // namespace haptic
