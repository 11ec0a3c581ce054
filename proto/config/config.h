// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "proto/os/message.h"
#include "proto/wire/mapping.h"
#include "proto/wire/proxy_solver.h"
#include "proto/wire/renderer.h"
#include "proto/wire/wire.h"

namespace haptic {

using Name = std::array<char, 64>;   // zero-terminated
using Path = std::array<char, 512>;  // zero-terminated

enum class DeviceKind : uint32_t { kSimulatedHand = 0, kReplay = 1, kWoodenHaptics = 2 };
/// How the servo waits for the next tick.
enum class Wake : uint32_t { kSleep = 0, kHybrid = 1 };
enum class MotionKind : uint32_t { kStatic = 0, kOscillate = 1, kSpin = 2 };
enum class Resampling : uint32_t { kCubic = 0, kHold = 1 };

/// Seeded intended motion of the simulated hand: minimum-jerk strokes over a ball around
/// `centre_B`. Each stroke goes from outside to `press_radius`, slides along an arc and lifts off.
struct IntentConfig {
  Vec3 centre_B;
  double hover_radius = 0.07;      // between strokes [m]
  double press_radius = 0.03;      // intended radius in a stroke: inside the object [m]
  double stroke_angle = 0.7;       // arc of a stroke [rad]
  Vec3 direction_B;                // initial direction of each stroke; zero: random for each
  double stroke_time = 1.2;        // of reach, slide and lift together [s]
  double tremor_amplitude = 1e-4;  // 8–12 Hz, peak [m]
};

/// Mass–damper device held by a human arm (Hogan 1989).
struct SimulatedHandConfig {
  uint64_t seed = 1;
  double mass = 0.1;               // moving mass of the device [kg]
  double damping = 1.0;            // [N·s/m]
  double coulomb_friction = 0.05;  // [N]
  double encoder_step = 2e-5;      // position quantum [m]; 0: none
  double hand_mass = 0.5;          // rigid grip [kg]
  double hand_damping = 5;         // [N·s/m]
  double hand_stiffness = 300;     // [N/m]
  double velocity_cutoff = 100;    // low-pass of the differentiated position [Hz]
  IntentConfig intent;
};

struct ReplayConfig {
  Path path{};
  Resampling resampling = Resampling::kCubic;
  uint32_t reserved = 0;
  double max_gap = 0.02;  // longer gaps in the recording are held and flagged [s]
  // 1-DoF recordings: x_B = lever_arm · column, along axis_B [m]; 0: the file holds x, y, z
  double lever_arm = 0;
  Vec3 axis_B{1, 0, 0};
  Name column{};  // of the lever angle [rad]
};

/// A device with a text protocol on a serial node (WoodenHaptics with a Teensy).
struct SerialConfig {
  Path path{};                   // of the device node
  double max_current = 3;        // per motor [A]
  double velocity_cutoff = 100;  // low-pass of the differentiated position [Hz]
};

struct DeviceConfig {
  DeviceKind kind = DeviceKind::kSimulatedHand;
  uint32_t reserved = 0;
  double max_force = 8;         // of the actuators [N], device units
  double max_torque = 0;        // [N·m]
  double continuous_force = 0;  // continuous (stall) rating of the motors [N]; 0: max_force
  double max_damping = 2;       // largest damper the device renders stably [N·s/m]
  Vec3 workspace_centre_B;      // [m]
  double workspace_radius = 0;  // [m]; 0: no edge
  // properties of a real device at its handle, for the margins of the coupling; 0: unknown
  double mass = 0;                // [kg]
  double damping = 0;             // [N·s/m]
  double inertia = 0;             // [kg·m²]
  double rotational_damping = 0;  // [N·m·s/rad]
  SimulatedHandConfig hand;
  ReplayConfig replay;
  SerialConfig serial;
};

/// Scripted motion about the configured pose: oscillate p = amplitude·sin(2πft)·axis, spin about
/// axis.
struct MotionConfig {
  MotionKind kind = MotionKind::kStatic;
  uint32_t reserved = 0;
  Vec3 axis_O{0, 0, 1};
  double amplitude = 0;  // [m]
  double frequency = 0;  // [Hz]; for spin, turns per second
};

enum class TextureKind : uint32_t { kNone = 0, kGrating = 1, kImage = 2 };

/// Heights of a texture as a grey image, by rows, 0 low to 255 high, repeated in both directions.
struct HeightImage {
  static constexpr uint32_t kMaxSide = 64;
  uint32_t width = 0, height = 0;
  std::array<uint8_t, kMaxSide * kMaxSide> grey{};
};
inline constexpr uint32_t kMaxImages = 4;  // limits the size of SessionConfig

/// Surface texture of an object, in the object's frame.
struct TextureConfig {
  TextureKind kind = TextureKind::kNone;
  uint32_t image = 0;         // index in SessionConfig::images
  double amplitude = 0;       // grating: of the sine; image: from black to white [m]
  double period = 0;          // grating: wavelength; image: width of one tile [m]
  Vec3 direction_O{1, 0, 0};  // grating: direction across its lines
};

/// Material of an object for the renderer virtual-proxy3.
struct MaterialConfig {
  double friction_static = 0;   // μ_s: sticks up to this ratio of tangential to normal force
  double friction_dynamic = 0;  // μ_d ≤ μ_s: that ratio while sliding
  double friction_viscous = 0;  // b: speed of sliding is limited by this damping [N·s/m]
  double stiffness_share = 1;   // s_s: share of the coupling's stiffness, 0 to 1
  double crease_angle = 0;      // edges with a smaller angle are shaded smooth; 0: no shading [rad]
  TextureConfig texture;
};

/// Dimensions of a generated machine part; each kind uses some of them.
struct PartConfig {
  double diameter = 0;   // of a peg, a hole's peg, a thread's crest [m]
  double length = 0;     // of a peg, a hole, a bolt [m]
  double clearance = 0;  // between the radii of a pair [m]
  double block = 0;      // edge of the square block around a hole [m]
  double module = 0;     // of a gear: pitch diameter over teeth [m]
  double width = 0;      // of a gear along its axis; of a nut across its flats [m]
  double bore = 0;       // diameter [m]
  double backlash = 0;   // of a gear, along the pitch circle [m]
  double pitch = 0;      // of a thread [m]
  double depth = 0;      // of a thread [m]
  double height = 0;     // of a nut [m]
  uint32_t teeth = 0;
  uint32_t around = 0, along = 0;  // segments of its mesh around and along the axis
};

/// A body: a mesh file or a generated mesh.
struct ShapeConfig {
  Name name{};
  Path mesh{};              // absolute; or "primitive:box", "primitive:sphere", "primitive:peg" …
  double unit = 0;          // metres per file unit; 0: any, scaled to `size`
  double size = 0;          // longest side of the bounding box [m]
  uint32_t allow_open = 0;  // 1: an open mesh is accepted as a one-sided surface
  uint32_t subdivisions = 0;  // of a primitive sphere (20·4ⁿ triangles)
  Vec3 extent;                // of a primitive's bounding box [m]
  PartConfig part;
};

struct ObjectConfig : ShapeConfig {
  Pose X_WO;
  MotionConfig motion;
  MaterialConfig material;
};

/// The tool of renderers with six degrees of freedom; no mesh: a point.
struct ToolConfig : ShapeConfig {
  double density = 0;  // gives mass and inertia of the closed mesh [kg/m³]; 0: use the two below
  double mass = 0.1;   // [kg]
  Vec3 inertia;  // about the axes of T through the centre of mass [kg·m²]; 0: that of a solid mesh
                 // of this mass
};

inline constexpr double kBandVoxels = 2;  // default band of a field beyond the force layer [voxels]

/// How the proxy of a 6-DoF tool moves.
struct ProxyConfig {
  // none: the renderer's own; direct for direct6, quasi-static for voxel
  std::optional<SoftSolver> solver;
  Integrator integrator = Integrator::kImplicit;  // of penalty dynamics
  double contact_stiffness = 1000;  // of contacts that give none: those of direct6 [N/m]
  double contact_damping = 0;       // of each contact along its normal [N·s/m]
};

/// The solver of a 6-DoF renderer: the session's, or the renderer's own.
inline SoftSolver solver_of(const ProxyConfig& proxy, Renderer renderer) {
  return proxy.solver.value_or(row_of(renderer).soft.value_or(SoftSolver::kQuasiStatic));
}

/// Whether a coupling pulls a proxy of the tool; false: the hand meets the contacts directly.
inline bool has_springs(const ProxyConfig& proxy, Renderer renderer) {
  return is_rigid(renderer) || solver_of(proxy, renderer) != SoftSolver::kDirect;
}

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

/// The verified pose of the renderers god-object6 and constrained6.
struct RigidConfig {
  double k_s = 2;      // of the paper: a move covers k_s/2 of the remaining way
  double margin = 0;   // to every surface [m]; 0: 1e-4 of the tool's radius
  uint32_t moves = 8;  // per step of contact, at most
};

/// Default band of a field [m]: the force layer and two voxels beyond it.
inline double default_band(const VoxelConfig& voxel) {
  return (voxel.offset_layers + kBandVoxels) * voxel.size;
}

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
  Renderer renderer = Renderer::kGodObject3;
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

/// A mistake in a session file: one line "file:line:column: what; how to mend".
struct ConfigError : MessageError {
  using MessageError::MessageError;
};

/// Reads, checks and resolves a TOML session file. Quantities are strings with a unit ("800 N/m",
/// "2 mm", "1 kHz"); relative paths are relative to the folder of the file. Throws ConfigError.
SessionConfig load_config(const std::string& path);

/// Parses text; `origin` is the path in messages and the base of relative paths.
SessionConfig parse_config(std::string_view toml_text, const std::string& origin);

/// Why a session cannot have this name, which becomes the name of a socket, and how to mend it;
/// empty if it can.
std::string session_name_problem(std::string_view name);

/// The unchanged text of a session file, for recordings. Throws ConfigError.
std::string read_config_text(const std::string& path);

/// Copies text into a fixed array; throws ConfigError if it does not fit.
template <size_t N>
void assign(std::array<char, N>& out, std::string_view text) {
  if (text.size() >= N) {
    throw ConfigError("'" + shown(text) + "' is longer than " + std::to_string(N - 1) +
                      " characters; shorten it");
  }
  out = {};
  text.copy(out.data(), N - 1);
}

template <size_t N>
std::string_view view(const std::array<char, N>& text) {
  return std::string_view(text.data());
}

/// Replaces the configured device by a recorded hand motion, played back open loop.
inline void use_trace(SessionConfig& config, const std::string& trace) {
  config.device.kind = DeviceKind::kReplay;
  assign(config.device.replay.path, trace);
}

}  // namespace haptic
