// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "proto/config/config_names.h"
#include "proto/math/pose.h"

namespace haptic {

/// A row of proto/config/devices.def; few need to know them (proto/config/devices.h).
enum class DeviceKind : uint32_t;

enum class Resampling : uint32_t { kCubic = 0, kHold = 1 };

/// A place that the simulated hand goes to.
struct Waypoint {
  Pose X_BH;
  double time = 0;  // from the waypoint before [s]; of the first: 0
  double rest = 0;  // at it [s]
};
inline constexpr uint32_t kMostWaypoints = 16;  // limits the size of SessionConfig

/// Seeded intended motion of the simulated hand: minimum-jerk strokes over a ball around
/// `centre_B`. Each stroke goes from outside to `press_radius`, slides along an arc and lifts off.
/// With waypoints the hand goes from one to the next instead, and stays at the last.
struct IntentConfig {
  Vec3 centre_B;
  double hover_radius = 0.07;      // between strokes [m]
  double press_radius = 0.03;      // intended radius in a stroke: inside the object [m]
  double stroke_angle = 0.7;       // arc of a stroke [rad]
  Vec3 direction_B;                // initial direction of each stroke; zero: random for each
  double stroke_time = 1.2;        // of reach, slide and lift together [s]
  double tremor_amplitude = 1e-4;  // 8–12 Hz, peak [m]
  double turn_angle = 0;           // of the handle in each stroke [rad]
  Vec3 turn_axis_B;                // of that turn, to either side; zero: random for each
  uint32_t n_waypoints = 0, reserved = 0;
  std::array<Waypoint, kMostWaypoints> waypoints{};
};

/// Mass–damper device held by a human arm (Hogan 1989), moving and turning.
struct SimulatedHandConfig {
  uint64_t seed = 1;
  double mass = 0.1;                  // moving mass of the device [kg]
  double damping = 1.0;               // [N·s/m]
  double coulomb_friction = 0.05;     // [N]
  double encoder_step = 2e-5;         // position quantum [m]; 0: none
  double hand_mass = 0.5;             // rigid grip [kg]
  double hand_damping = 5;            // [N·s/m]
  double hand_stiffness = 300;        // [N/m]
  double velocity_cutoff = 100;       // low-pass of the differentiated pose [Hz]
  double inertia = 0;                 // of the handle about every axis [kg·m²]; 0: it cannot turn
  double rotational_damping = 5e-3;   // [N·m·s/rad]
  double rotational_friction = 5e-4;  // Coulomb's [N·m]
  double angle_step = 2e-4;           // quantum of the rotation vector [rad]; 0: none
  double hand_inertia = 1e-3;         // of the hand with its grip [kg·m²]
  double hand_rotational_damping = 0.02;  // [N·m·s/rad]
  double hand_rotational_stiffness = 2;   // [N·m/rad]
  IntentConfig intent;
};

/// The virtual body that an admittance device shows to the hand: M dV/dt = F_hand + F_scene − D V.
struct AdmittanceConfig {
  double mass = 2;                   // [kg]
  double damping = 5;                // [N·s/m]
  double inertia = 4e-3;             // about every axis [kg·m²]
  double rotational_damping = 0.01;  // [N·m·s/rad]
  double arm_delay = 0;              // of a simulated arm, from command to motion [s]
};

struct ReplayConfig {
  Path path{};
  Resampling resampling = Resampling::kCubic;
  uint32_t loop = 0;         // 1: again and again, with a soft return
  uint32_t closed_loop = 0;  // 1: the recording is the intention of the hand of [device.hand]
  uint32_t reserved = 0;
  double speed = 1;       // of the playback
  double from = 0;        // start of the played part, from the first sample [s]
  double to = 0;          // its end, likewise; 0: that of the recording [s]
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

/// Which of several devices of a kind that are plugged in; both empty: the only one.
struct PluggedConfig {
  Name serial{};  // serial number, as `hapt devices` prints it
  Name port{};    // USB port, "1-2.3", for devices without a serial number
};

/// A Novint Falcon.
struct FalconConfig {
  Path firmware{};               // file with the firmware's image; empty: it must run already
  double velocity_cutoff = 100;  // low-pass of the differentiated position [Hz]
};

/// An arm of three joints driven by capstans, behind a board with HID reports (WoodenHaptics and
/// its relatives). Joint angle: sign · 2π · counts · capstan / (counts_per_turn · body) + home. The
/// joints are A about the vertical, the upper arm's lean from standing, the forearm's rise from
/// hanging. The defaults are the WoodenHaptics of 2016.
struct HidArmConfig {
  Vec3 links{0.080, 0.205, 0.245};       // height of the shoulder, upper arm, forearm [m]
  Vec3 capstans{0.010, 0.010, 0.010};    // diameters [m]
  Vec3 bodies{0.160, 0.120, 0.120};      // diameters of the driven bodies [m]
  Vec3 signs{-1, -1, -1};                // of a joint's angle by its counts: 1 or −1
  Vec3 motor_signs{1, -1, -1};           // of a joint's torque by its motor's current
  Vec3 homes{0, 0, 1.5707963267948966};  // joint angles where the counts are zero [rad]
  double counts_per_turn = 2000;         // of a motor, all four edges
  double torque_constant = 0.0259;       // [N·m/A]
  double max_current = 3;                // per motor [A]
  double velocity_cutoff = 100;          // low-pass of the differentiated position [Hz]
};

/// A sprung knob whose deflection commands a velocity.
struct RateDeviceConfig {
  double speed = 0.2;       // of the handle at full deflection [m/s]
  double turn_rate = 1.5;   // [rad/s]
  double dead_band = 0.05;  // share of the full deflection that counts as none
  double full_scale = 350;  // counts of a full deflection
};

/// A five-bar linkage in a plane, its motors `base` apart.
struct PantographConfig {
  double proximal = 0.05;                    // length of the driven links [m]
  double distal = 0.07;                      // of the others [m]
  double base = 0.02;                        // [m]
  double counts_per_turn = 13824;            // of a driven link
  double offset_1 = 3.14159265358979323846;  // angle of link 1 where the board starts [rad]
  double offset_2 = 0;                       // of link 2 [rad]
  double sign_1 = 1;             // of link 1's angle and torque by its port's: 1 or −1
  double sign_2 = 1;             // of link 2's
  double reduction = 1;          // torque of a link per torque that the board is told
  double max_torque = 0.123;     // that the board may be told, each motor [N·m]
  double velocity_cutoff = 100;  // low-pass of the differentiated position [Hz]
  uint32_t port_1 = 1;           // of the board, for link 1: 1 or 2; link 2 has the other
  uint32_t reserved = 0;
};

/// A body that gravity pulls at: a link of an arm, or its handle.
struct LinkMass {
  double mass = 0;  // [kg]; negative: a counterweight's
  Vec3 centre;      // of mass, in the link's own axes (docs/config.md); of the handle: in H [m]
};
inline constexpr size_t kMostLinks = 3;  // beside the handle; of the Polhem

/// The masses that an arm's motors hold up. All zero: they hold up nothing.
struct GravityConfig {
  Vec3 down_B;  // unit; zero: that of the arm (Arm::down)
  LinkMass handle;
  std::array<LinkMass, kMostLinks> links{};  // in the order of DeviceRow::links
};

constexpr bool has_weight(const GravityConfig& gravity) {
  bool has = gravity.handle.mass != 0;
  for (const LinkMass& link : gravity.links) has |= link.mass != 0;
  return has;
}

struct DeviceConfig {
  DeviceKind kind{};
  uint32_t reserved = 0;
  double max_force = 8;          // of the actuators [N], device units
  double max_torque = 0;         // [N·m]
  double continuous_force = 0;   // continuous (stall) rating of the motors [N]; 0: max_force
  double continuous_torque = 0;  // the same for torque [N·m]; 0: max_torque
  // largest damper the device renders stably
  double max_damping = 2;                // [N·s/m]
  double max_rotational_damping = 0.01;  // [N·m·s/rad]; 2 N·s/m at 70 mm
  Vec3 workspace_centre_B;               // [m]
  double workspace_radius = 0;           // [m]; 0: no edge
  Quat workspace_rest_B;                 // orientation of the handle in the middle of its range
  double workspace_turn = 0;             // largest rotation away from it [rad]; 0: no edge
  // properties of a real device at its handle, for the margins of the coupling; 0: unknown
  double mass = 0;                // [kg]
  double damping = 0;             // [N·s/m]
  double inertia = 0;             // [kg·m²]
  double rotational_damping = 0;  // [N·m·s/rad]
  SimulatedHandConfig hand;
  AdmittanceConfig admittance;
  ReplayConfig replay;
  SerialConfig serial;
  PluggedConfig plugged;
  FalconConfig falcon;
  HidArmConfig hid_arm;
  RateDeviceConfig rate;
  PantographConfig pantograph;
  GravityConfig gravity;
};

}  // namespace haptic
