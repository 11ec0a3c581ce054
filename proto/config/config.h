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
/// How the servo waits for its next tick.
enum class Wake : uint32_t { kSleep = 0, kHybrid = 1 };
enum class MotionKind : uint32_t { kStatic = 0, kOscillate = 1, kSpin = 2 };
enum class Resampling : uint32_t { kCubic = 0, kHold = 1 };

/// The seeded intention of the simulated hand: minimum-jerk strokes over a ball around `centre_B`.
/// Each stroke reaches from outside to `press_radius`, slides along the arc, and lifts off again.
struct IntentConfig {
  Vec3 centre_B;
  double hover_radius = 0.07;      // between strokes [m]
  double press_radius = 0.03;      // where the intention goes: inside the object [m]
  double stroke_angle = 0.7;       // of the arc of a stroke [rad]
  Vec3 direction_B;                // each stroke begins along it; zero: anew for each stroke
  double stroke_time = 1.2;        // one stroke: reach, slide, lift [s]
  double tremor_amplitude = 1e-4;  // 8–12 Hz, peak [m]
};

/// Mass–damper device held by a human arm (devices.md §4 of the reference; Hogan 1989).
struct SimulatedHandConfig {
  uint64_t seed = 1;
  double mass = 0.1;               // moving mass of the device [kg]
  double damping = 1.0;            // [N·s/m]
  double coulomb_friction = 0.05;  // [N]
  double encoder_step = 2e-5;      // position quantum [m]; 0: none
  double hand_mass = 0.5;          // rigid grip [kg]
  double hand_damping = 5;         // [N·s/m]
  double hand_stiffness = 300;     // [N/m]
  double velocity_cutoff = 100;    // of the differentiated position [Hz]
  IntentConfig intent;
};

struct ReplayConfig {
  Path path{};
  Resampling resampling = Resampling::kCubic;
  uint32_t reserved = 0;
  double max_gap = 0.02;  // longer holes in the recording are held and flagged [s]
  // 1-DoF recordings: x_B = lever_arm · column, along axis_B; 0: the file holds x, y, z
  double lever_arm = 0;
  Vec3 axis_B{1, 0, 0};
  Name column{};  // of the lever angle [rad]
};

/// A device behind a serial node that speaks text (WoodenHaptics with a Teensy).
struct SerialConfig {
  Path path{};                   // of the node
  double max_current = 3;        // of a motor [A]
  double velocity_cutoff = 100;  // of the differentiated position [Hz]
};

struct DeviceConfig {
  DeviceKind kind = DeviceKind::kSimulatedHand;
  uint32_t reserved = 0;
  double max_force = 8;         // of the actuators [N], device units
  double max_torque = 0;        // [N·m]
  double continuous_force = 0;  // what they bear for ever [N]; 0: max_force
  double max_damping = 2;       // the largest damper the device renders stably [N·s/m]
  Vec3 workspace_centre_B;      // [m]
  double workspace_radius = 0;  // [m]; 0: no edge
  // what a real device is made of, as its handle feels it, for the margins of the coupling; 0: not
  // known
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

/// Heights of a texture, a grey image: row by row, 0 low to 255 high. It repeats in both
/// directions.
struct HeightImage {
  static constexpr uint32_t kMaxSide = 64;
  uint32_t width = 0, height = 0;
  std::array<uint8_t, kMaxSide * kMaxSide> grey{};
};
inline constexpr uint32_t kMaxImages = 4;

/// What the surface of an object adds to its shape, in the object's frame.
struct TextureConfig {
  TextureKind kind = TextureKind::kNone;
  uint32_t image = 0;         // index in SessionConfig::images
  double amplitude = 0;       // grating: of the sine; image: from black to white [m]
  double period = 0;          // grating: wavelength; image: width of one tile [m]
  Vec3 direction_O{1, 0, 0};  // grating: across its lines
};

/// How an object feels to the renderer virtual-proxy3.
struct MaterialConfig {
  double friction_static = 0;   // μ_s: sticks up to this ratio of tangential to normal force
  double friction_dynamic = 0;  // μ_d ≤ μ_s: the ratio while it slides
  double friction_viscous = 0;  // b: the sliding proxy gains speed against this [N·s/m]
  double stiffness_share = 1;   // s_s: of the coupling's stiffness, 0 to 1
  double crease_angle = 0;      // edges that turn by less are shaded away; 0: no shading [rad]
  TextureConfig texture;
};

/// Dimensions of a part of a machine that the program makes; of each kind those it has.
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
  uint32_t around = 0, along = 0;  // steps that the part is cut into
};

/// A body: a mesh, or what the program makes.
struct ShapeConfig {
  Name name{};
  Path mesh{};              // absolute; or "primitive:box", "primitive:sphere", "primitive:peg" …
  double unit = 0;          // metres per file unit; 0: any, scaled so that the longest side is size
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

/// What the hand holds, for the renderers with six degrees of freedom; no mesh: a point.
struct ToolConfig : ShapeConfig {
  double density = 0;  // mass and inertia are those of the closed mesh [kg/m³]; 0: as below
  double mass = 0.1;   // [kg]
  Vec3 inertia;  // about the axes of T through the centre of mass [kg·m²]; 0: as if the mesh
                 // were filled evenly
};

inline constexpr double kBandVoxels = 2;  // of a field's band beyond the force layer, by default

/// What a tool with six degrees of freedom is moved by.
struct ProxyConfig {
  // none: each renderer's own: direct6 has direct, voxel quasi-static
  std::optional<SoftSolver> solver;
  Integrator integrator = Integrator::kImplicit;  // of penalty dynamics
  double contact_stiffness = 1000;  // of contacts that name none: those of direct6 [N/m]
  double contact_damping = 0;       // of each contact along its normal [N·s/m]
};

/// The solver of a renderer with six degrees of freedom: the session's, or its own.
inline SoftSolver solver_of(const ProxyConfig& proxy, Renderer renderer) {
  return proxy.solver.value_or(row_of(renderer).soft.value_or(SoftSolver::kQuasiStatic));
}

/// Whether springs lead a proxy of the tool, instead of the hand meeting the contacts itself.
inline bool has_springs(const ProxyConfig& proxy, Renderer renderer) {
  return is_rigid(renderer) || solver_of(proxy, renderer) != SoftSolver::kDirect;
}

/// Which braking force of the paper's two readings.
enum class Braking : uint32_t {
  kAlongVelocity = 0,  // −b v (−n̂·v̂), McNeely's own
  kAlongNormal = 1     // −b (v·n̂) n̂, as a review has it
};

/// Maps, field and points of the detector `voxel`.
struct VoxelConfig {
  double size = 1e-3;           // of a voxel, and a cell of the field [m]
  double band = 4e-3;           // within which the field is stored [m]
  double point_spacing = 1e-3;  // of the tool's points [m]
  double stiffness = 1000;      // of a point [N/m]
  double braking = 0;           // of approaching points [N·s/m]
  Braking braking_along = Braking::kAlongVelocity;
  uint32_t offset_layers = 2;  // by which surfaces lie outside the real ones, in voxels
  uint32_t field = 1;          // 1: a distance field is baked, 0: the map of voxels alone
  uint32_t open_as_sheet = 0;  // 1: a mesh that is not closed is a sheet one voxel thick
  uint32_t budget = 30000;     // of points that a step may look up; 0: any number
  uint32_t is_wanted = 0;      // the section is there: baked even where another renderer begins
};

/// The verified pose of the renderers god-object6 and constrained6.
struct RigidConfig {
  double k_s = 2;      // of the paper: a move goes k_s/2 of what is left of the way
  double margin = 0;   // kept to every surface [m]; 0: 1e-4 of the tool's radius
  uint32_t moves = 8;  // in one step of contact, at most
};

/// The band of a field where nobody says otherwise: the layer, and two voxels beyond it.
inline double default_band(const VoxelConfig& voxel) {
  return (voxel.offset_layers + kBandVoxels) * voxel.size;
}

struct CouplingConfig {
  double translational_stiffness = 800;  // [N/m], scene units
  double translational_damping = 0;      // [N·s/m]
  double rotational_stiffness = 0;       // [N·m/rad]
  double rotational_damping = 0;         // [N·m·s/rad]
  double max_force = 0;                  // of the spring on a body's proxy; 0: no bound [N]
  double max_torque = 0;                 // the same [N·m]
};

struct SafetyConfig {
  double max_force = 6;          // [N], device units; the device's own limit holds too
  double max_torque = 0.1;       // [N·m]
  double soft_start = 0.5;       // ramp after start, fault and re-seeding [s]
  double slew = 2000;            // of a force that grows by itself, not by the hand's motion [N/s]
  double velocity_limit = 2;     // of the handle [m/s]
  int32_t dead_man_button = -1;  // bit that must be held; −1: none
  uint32_t armed_at_start = 1;   // 0: `hapt arm` is wanted first, the default of a real device
};

/// A parsed, checked session. Trivially copyable: hapticd parses the file once and hands this copy
/// to every process it starts or restarts, in a sealed memfd.
struct SessionConfig {
  Name name{};
  Path file{};                      // where it came from
  double servo_rate = 1000;         // [Hz]
  double contact_poll_rate = 4000;  // how often contact looks again for a late ServoFrame [Hz]
  double sim_rate = 120;            // [Hz]
  uint64_t mesh_memory_limit = uint64_t{4} << 30;  // bytes a mesh may need while it is baked
  uint32_t realtime = 1;                           // 0: do not even ask for FIFO and locked memory
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
  uint32_t contact_spare = 1;  // 0: no second contact waits for the first to die
  std::array<HeightImage, kMaxImages> images{};
};
static_assert(std::is_trivially_copyable_v<SessionConfig>);

/// What is wrong with a file a person wrote: one line "file:line:column: what; how to mend".
struct ConfigError : MessageError {
  using MessageError::MessageError;
};

/// Reads, checks and resolves a TOML session file. Quantities are strings with a unit ("800 N/m",
/// "2 mm", "1 kHz"); relative paths are taken from the folder of the file. Throws ConfigError.
SessionConfig load_config(const std::string& path);

/// The same for text; `origin` is the path named in errors and the base of relative paths.
SessionConfig parse_config(std::string_view toml_text, const std::string& origin);

/// Why a session cannot have this name (it becomes the name of a socket), how to mend it; empty
/// where it can.
std::string session_name_problem(std::string_view name);

/// The text of a session file as it is, to be kept in a recording. Throws ConfigError.
std::string read_config_text(const std::string& path);

/// Copies text into a fixed array; throws ConfigError when it does not fit.
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

/// Replaces the configured device by a recording of a hand, played back open loop.
inline void use_trace(SessionConfig& config, const std::string& trace) {
  config.device.kind = DeviceKind::kReplay;
  assign(config.device.replay.path, trace);
}

}  // namespace haptic
