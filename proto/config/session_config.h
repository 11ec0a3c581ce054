// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "proto/config/client_config.h"
#include "proto/config/config_names.h"
#include "proto/config/device_config.h"
#include "proto/config/joint_config.h"
#include "proto/config/scene_config.h"
#include "proto/wire/mapping.h"
#include "proto/wire/proxy_solver.h"
#include "proto/wire/wire.h"

namespace haptic {

/// A row of proto/wire/renderers.def; few need to know them (proto/wire/renderer.h).
enum class Renderer : uint32_t;

inline constexpr double kBandVoxels = 2;  // default band of a field beyond the force layer [voxels]

/// How contacts with one object share their stiffness.
enum class Sharing : uint32_t {
  kCorners = 0,  // from four on, the corners of a box, all have what four would
  kNone = 1      // each has its own
};

/// How the proxy of a 6-DoF tool moves.
struct ProxyConfig {
  // none: the renderer's own; direct for direct6, quasi-static for voxel
  std::optional<SoftSolver> solver;
  Integrator integrator = Integrator::kImplicit;  // of penalty dynamics
  double contact_stiffness = 1000;      // of contacts that give none: those of direct6 [N/m]
  double contact_damping = 0;           // of each contact along its normal [N·s/m]
  Sharing sharing = Sharing::kCorners;  // of those of direct6, localized and sensation
};

/// The two readings of the braking force of McNeely, Puterbaugh, Troy 1999.
enum class Braking : uint32_t {
  kAlongVelocity = 0,  // −b v (−n̂·v̂), the paper's
  kAlongNormal = 1     // −b (v·n̂) n̂, a later review's
};

/// Maps, field and points of the detector `voxel`.
struct VoxelConfig {
  double size = 1e-3;           // edge of a voxel and of a cell of the field [m]
  double band = 4e-3;           // distance from the surface within which the field is exact [m]
  double point_spacing = 1e-3;  // of the tool's points [m]
  double stiffness = 1000;      // per point [N/m]
  double braking = 0;           // of approaching points [N·s/m]
  Braking braking_along = Braking::kAlongVelocity;
  uint32_t offset_layers = 2;  // distance of the felt surface outside the real one [voxels]
  uint32_t field = 1;          // 1: a distance field is baked; 0: the voxel map alone
  uint32_t open_as_sheet = 0;  // 1: an open mesh becomes a sheet one voxel thick
  uint32_t budget = 30000;     // points looked up per step; 0: unlimited
  uint32_t is_wanted = 0;      // 1: the section is present: baked even if another renderer starts
};

/// Convex pieces and contact levels of detail, of the renderers localized and sensation.
struct PieceConfig {
  double threshold = 50e-6;   // s0, haptic error beyond which sensation refines [m]
  double carry = 20e-6;       // motion until sensation asks a pair in contact again [m]
  double bandwidth = 0;       // detail that slides past more often is left out [Hz]; 0: none
  uint32_t budget = 2000;     // pairs of pieces that sensation tests per step; 0: unlimited
  double cluster_radius = 0;  // [m]; 0: a quarter of the tool's radius
  uint32_t is_wanted = 0;     // 1: the section is present: baked even if another renderer starts
};

/// The verified pose of the renderers god-object6 and constrained6.
struct RigidConfig {
  double k_s = 2;      // of the paper: a move covers k_s/2 of the remaining way
  double margin = 0;   // to every surface [m]; 0: 1e-4 of the tool's radius
  uint32_t moves = 8;  // per step of contact, at most
  RigidSolver solver = RigidSolver::kCoulomb;  // of constrained6
};

/// Default band of a field [m]: the force layer and two voxels beyond it.
inline double default_band(const VoxelConfig& voxel) {
  return (voxel.offset_layers + kBandVoxels) * voxel.size;
}

/// How the servo waits for the next tick.
enum class Wake : uint32_t { kSleep = 0, kHybrid = 1 };

/// The virtual coupling: springs and dampers between hand and proxy, in scene units.
struct Coupling {
  double translational_stiffness = 0;  // k_T [N/m]
  double translational_damping = 0;    // b_T [N·s/m]
  double rotational_stiffness = 0;     // k_R [N·m/rad], 6-DoF tools only
  double rotational_damping = 0;       // b_R [N·m·s/rad]
  double max_force = 0;                // of the spring on a 6-DoF proxy; 0: no bound [N]
  double max_torque = 0;               // likewise [N·m]; 0: no bound

  bool operator==(const Coupling&) const = default;
};

struct SafetyConfig {
  double max_force = 6;     // [N], device units; the device's own limit applies too
  double max_torque = 0.1;  // [N·m]
  double soft_start = 0.5;  // ramp after start, fault and re-seeding [s]
  double slew = 2000;       // of a force that grows without motion of the hand [N/s]
  // of a torque that does [N·m/s]; 0: to its limit in as long as the force to its own
  double torque_slew = 0;
  double velocity_limit = 2;           // of the handle [m/s]
  double angular_velocity_limit = 20;  // [rad/s]
  int32_t dead_man_button = -1;        // bit that must be held; −1: none
  uint32_t armed_at_start = 1;         // 0: waits for `hapt arm`, the default of a real device
};

/// A parsed and checked session, as one of its hands has it. Trivially copyable: hapticd parses the
/// file once and hands each process that it starts the copy of its hand, in a sealed memfd. The
/// scene is the same in all.
struct SessionConfig {
  Name name{};
  uint32_t hand = kFirstHand;  // the hand that device, map, tool, renderer and limits are of
  uint32_t n_hands = 1;        // of the session
  std::array<Name, kMostHands> hand_names{};  // "" where the session file has no [[hand]]
  uint32_t hands_touch = 1;         // 0: the tools of other hands are no objects for this one
  uint32_t n_tools = 0;             // of the objects, the last: tools of other hands (with_tools)
  Path file{};                      // path of the session file
  double servo_rate = 1000;         // [Hz]
  double contact_poll_rate = 4000;  // how often contact looks again for a late ServoFrame [Hz]
  double sim_rate = 120;            // [Hz]; 1 kHz where something can be pushed
  Vec3 gravity_W;                   // of the bodies with mass [m/s²]
  double sim_reach = 1;             // of a body from its place at the start; beyond it stays [m]
  uint64_t mesh_memory_limit = uint64_t{4} << 30;  // limit while a mesh is baked [bytes]
  uint32_t realtime = 1;                           // 0: no real-time priority or locked memory
  Renderer renderer{};
  double proxy_radius = 1e-3;  // of virtual-proxy3; 0: a point [m]
  VoxelConfig voxel;
  PieceConfig pieces;
  RigidConfig rigid;
  ToolConfig tool;
  ProxyConfig proxy;
  DeviceMap map;
  DeviceConfig device;
  Coupling coupling{.translational_stiffness = 800};
  SafetyConfig safety;
  uint32_t n_objects = 0;
  Wake servo_wake = Wake::kSleep;
  std::array<ObjectConfig, kMaxObjects> objects{};
  uint32_t n_joints = 0, reserved_joints = 0;
  std::array<JointConfig, kMaxJoints> joints{};
  uint32_t n_clients = 0, reserved_clients = 0;
  std::array<ClientConfig, kMostClients> clients{};
  uint32_t n_images = 0;
  uint32_t contact_spare = 1;  // 0: no spare contact process
  std::array<HeightImage, kMaxImages> images{};
};
static_assert(std::is_trivially_copyable_v<SessionConfig>);

/// Returns whether a client may move this object.
inline bool is_moved_by_client(const SessionConfig& config, uint32_t object) {
  for (uint32_t c = 0; c < config.n_clients; ++c) {
    const ClientConfig& client = config.clients[c];
    for (uint32_t i = 0; i < client.n_moves; ++i) {
      if (client.moves[i] == object) return true;
    }
  }
  return false;
}

}  // namespace haptic
