// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/config_device.h"

#include <array>
#include <numbers>
#include <string>
#include <vector>

#include "proto/config/devices.h"

namespace haptic {

using enum Dimension;

namespace fs = std::filesystem;

#define DEVICE(id, name, open, read, ...) ReadDevice read;
#include "proto/config/devices.def"

namespace {

constexpr auto kDeviceWords = words_of(kDevices);
constexpr Words<Resampling, 2> kResamplings{
    {{"cubic", Resampling::kCubic}, {"hold", Resampling::kHold}}};
constexpr Range kIntendedTurns{0, std::numbers::pi};  // [rad]; farther is the shorter way round
constexpr double kMostArmDelay = 0.05;  // [s]; longer than any arm that a hand could still lead
constexpr Range kCurrents{0, 6, true};  // [A]; the firmware treats larger values as zero

/// Keys of strokes, which a hand with waypoints does not make.
constexpr std::array<std::string_view, 8> kStrokeKeys{
    "centre",    "hover_radius", "press_radius", "stroke_angle",
    "direction", "stroke_time",  "turn_angle",   "turn_axis"};

void read_waypoints(Section& intent, IntentConfig& config) {
  std::vector<Section> places = intent.sections("waypoint");
  if (places.empty()) return;
  for (const std::string_view key : kStrokeKeys) {
    if (!intent.has(key)) continue;
    intent.fail_at(key, "belongs to strokes; a hand with waypoints makes none, leave it out");
  }
  if (places.size() < 2) {
    intent.fail_at("waypoint", "leads nowhere; write two [[device.hand.intent.waypoint]] or more");
  }
  for (Section& place : places) {
    if (config.n_waypoints == kMostWaypoints) {
      place.fail_at("position", "is of one waypoint too many; " + std::to_string(kMostWaypoints) +
                                    " are the most");
    }
    Waypoint& waypoint = config.waypoints[config.n_waypoints];
    place.require("position", "position = [\"0 mm\", \"50 mm\", \"0 mm\"]");
    place.read_pose(waypoint.X_BH);
    if (config.n_waypoints > 0) {
      place.read_all(
          {{"time", kTime, kPositive, waypoint.time, "time = \"2 s\", from the waypoint before"}});
    }
    place.read_quantity("rest", kTime, kNotNegative, waypoint.rest);
    place.finish();
    ++config.n_waypoints;
  }
}

void read_intent(Section& hand, IntentConfig& intent) {
  hand.within("intent", [&](Section& section) {
    section.read_all({{"centre", kLength, kAny, intent.centre_B},
                      {"hover_radius", kLength, kPositive, intent.hover_radius},
                      {"press_radius", kLength, kNotNegative, intent.press_radius},
                      {"stroke_angle", kAngle, kNotNegative, intent.stroke_angle}});
    section.read_direction("direction", intent.direction_B);
    section.read_all({{"stroke_time", kTime, kPositive, intent.stroke_time},
                      {"tremor_amplitude", kLength, kNotNegative, intent.tremor_amplitude},
                      {"turn_angle", kAngle, kIntendedTurns, intent.turn_angle}});
    section.read_direction("turn_axis", intent.turn_axis_B);
    read_waypoints(section, intent);
  });
}

/// The masses of a device's links, by the names in its row.
void read_gravity(Section& device, DeviceConfig& config) {
  static constexpr Range kMasses{-10, 10}, kPlaces{-1, 1};  // [kg], [m]; beyond any desk's arm
  GravityConfig& gravity = config.gravity;
  const auto read_link = [](Section& section, std::string_view name, LinkMass& link) {
    section.within(name, [&](Section& body) {
      body.read_all({{"mass", kMass, kMasses, link.mass, "mass = \"120 g\""},
                     {"centre", kLength, kPlaces, link.centre}});
    });
  };
  const auto& names = row_of(config.kind).links;
  if (device.has("gravity") && names[0].empty()) {
    device.fail_at("gravity",
                   "needs motors that hold up an arm; this device has none, leave it out");
  }
  device.within("gravity", [&](Section& section) {
    section.read_direction("down", gravity.down_B);
    read_link(section, names[0], gravity.handle);
    for (size_t i = 1; i < names.size() && !names[i].empty(); ++i) {
      read_link(section, names[i], gravity.links[i - 1]);
    }
  });
}

}  // namespace

void read_hand(Section& device, const fs::path&, DeviceConfig& config) {
  device.within("hand", [&](Section& section) {
    SimulatedHandConfig& hand = config.hand;
    section.read_all(
        {{"seed", 0, std::numeric_limits<int64_t>::max(), hand.seed},
         {"mass", kMass, kPositive, hand.mass},
         {"damping", kDamping, kNotNegative, hand.damping},
         {"coulomb_friction", kForce, kNotNegative, hand.coulomb_friction},
         {"encoder_step", kLength, kNotNegative, hand.encoder_step},
         {"hand_mass", kMass, kNotNegative, hand.hand_mass},
         {"hand_damping", kDamping, kNotNegative, hand.hand_damping},
         {"hand_stiffness", kStiffness, kNotNegative, hand.hand_stiffness},
         {"velocity_cutoff", kFrequency, kPositive, hand.velocity_cutoff},
         {"inertia", kInertia, kNotNegative, hand.inertia},
         {"rotational_damping", kRotationalDamping, kNotNegative, hand.rotational_damping},
         {"rotational_friction", kTorque, kNotNegative, hand.rotational_friction},
         {"angle_step", kAngle, kNotNegative, hand.angle_step},
         {"hand_inertia", kInertia, kNotNegative, hand.hand_inertia},
         {"hand_rotational_damping", kRotationalDamping, kNotNegative,
          hand.hand_rotational_damping},
         {"hand_rotational_stiffness", kRotationalStiffness, kNotNegative,
          hand.hand_rotational_stiffness}});
    read_intent(section, hand.intent);
  });
}

void read_admittance(Section& device, const fs::path&, DeviceConfig& config) {
  constexpr Range kDelays{0, kMostArmDelay};
  device.within("admittance", [&](Section& section) {
    AdmittanceConfig& body = config.admittance;
    section.read_all(
        {{"mass", kMass, kPositive, body.mass},
         {"damping", kDamping, kNotNegative, body.damping},
         {"inertia", kInertia, kPositive, body.inertia},
         {"rotational_damping", kRotationalDamping, kNotNegative, body.rotational_damping},
         {"arm_delay", kTime, kDelays, body.arm_delay}});
  });
}

void read_replay(Section& device, const fs::path& config_folder, DeviceConfig& config) {
  const bool is_needed = row_of(config.kind).is_recorded;
  device.within(
      "replay",
      [&](Section& section) {
        ReplayConfig& replay = config.replay;
        section.require("path", "path = \"hand.csv\"");
        // not checked for existence here: `hapt replay` may name another file
        section.read_path("path", config_folder, replay.path);
        section.read_all({{"resampling", kResamplings, replay.resampling},
                          {"max_gap", kTime, kPositive, replay.max_gap},
                          {"speed", kReplaySpeeds, replay.speed},
                          {"from", kTime, kNotNegative, replay.from},
                          {"to", kTime, kPositive, replay.to},
                          {"loop", replay.loop},
                          {"closed_loop", replay.closed_loop},
                          {"column", replay.column}});
        section.read_direction("axis", replay.axis_B);
        if (section.read_quantity("lever_arm", kLength, kPositive, replay.lever_arm)) {
          section.require("column",
                          "column = \"lever_rad\" (the angle the lever arm is multiplied by)");
        }
      },
      is_needed ? "[device.replay] with path = \"hand.csv\"" : nullptr);
}

void read_serial(Section& device, const fs::path&, DeviceConfig& config) {
  const bool is_needed = row_of(config.kind).node == NodeKind::kSerial;
  device.within(
      "serial",
      [&](Section& section) {
        SerialConfig& serial = config.serial;
        section.read_all({{"path", serial.path, "path = \"/dev/ttyACM0\""},
                          {"max_current", kCurrent, kCurrents, serial.max_current},
                          {"velocity_cutoff", kFrequency, kPositive, serial.velocity_cutoff}});
      },
      is_needed ? "[device.serial] with path = \"/dev/ttyACM0\"" : nullptr);
}

void read_device(Section& root, const fs::path& config_folder, DeviceConfig& device) {
  constexpr Range kHalfTurn{0, std::numbers::pi, true};  // no rotation is farther from another
  const auto read = [&](Section& section) {
    section.require("kind", "kind = \"simulated-hand\"");
    section.read_choice("kind", kDeviceWords, device.kind,
                        " (other hardware needs a driver: docs/adding.md)");
    section.read_all({{"max_force", kForce, kPositive, device.max_force},
                      {"max_torque", kTorque, kNotNegative, device.max_torque},
                      {"continuous_force", kForce, kPositive, device.continuous_force},
                      {"continuous_torque", kTorque, kPositive, device.continuous_torque},
                      {"max_damping", kDamping, kNotNegative, device.max_damping},
                      {"max_rotational_damping", kRotationalDamping, kNotNegative,
                       device.max_rotational_damping},
                      {"workspace_centre", kLength, kAny, device.workspace_centre_B},
                      {"workspace_radius", kLength, kPositive, device.workspace_radius}});
    section.read_rotation("workspace_rest", device.workspace_rest_B);
    section.read_all(
        {{"workspace_turn", kAngle, kHalfTurn, device.workspace_turn},
         {"mass", kMass, kPositive, device.mass},
         {"damping", kDamping, kNotNegative, device.damping},
         {"inertia", kInertia, kPositive, device.inertia},
         {"rotational_damping", kRotationalDamping, kNotNegative, device.rotational_damping}});
    section.within("usb", [&](Section& usb) {
      usb.read_all({{"serial", device.plugged.serial}, {"port", device.plugged.port}});
    });
    read_gravity(section, device);
#define DEVICE(id, name, open, read, ...) read(section, config_folder, device);
#include "proto/config/devices.def"
  };
  root.within("device", read, "[device] with kind = \"simulated-hand\"");
}

}  // namespace haptic
