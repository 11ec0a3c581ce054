// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/stability/axis_options.h"

#include <array>

#include "clients/hapt/options.h"
#include "proto/config/devices.h"
#include "proto/os/session_file.h"

namespace haptic {
namespace {

using Hand = SimulatedHandConfig;

/// A quantity of the axis: of moving, and of turning.
struct AxisKey {
  const char *name, *help;
  Dimension moving, turning;
  const char *moving_unit, *turning_unit;  // of a bare number, as in quantity.cpp
  Range range;
};

struct DeviceKey : AxisKey {
  double Hand::*moving_value;
  double Hand::*turning_value;
};

constexpr Range kFrom0{0, 1e9}, kAbove0{0, 1e9, true};

const std::array kDeviceKeys{
    DeviceKey{{"--mass", "of the device, or its handle's inertia", Dimension::kMass,
               Dimension::kInertia, "kg", "kgm²", kAbove0},
              &Hand::mass,
              &Hand::inertia},
    DeviceKey{{"--device-damping", "of the device itself", Dimension::kDamping,
               Dimension::kRotationalDamping, "Ns/m", "Nms/rad", kFrom0},
              &Hand::damping,
              &Hand::rotational_damping},
    DeviceKey{{"--friction", "Coulomb's, of the device", Dimension::kForce, Dimension::kTorque, "N",
               "Nm", kFrom0},
              &Hand::coulomb_friction,
              &Hand::rotational_friction},
    DeviceKey{{"--encoder", "step of the encoder; 0: none", Dimension::kLength, Dimension::kAngle,
               "m", "rad", kFrom0},
              &Hand::encoder_step,
              &Hand::angle_step}};

const AxisKey kStiffnessKey{"--stiffness",
                            "of the coupling, at the device",
                            Dimension::kStiffness,
                            Dimension::kRotationalStiffness,
                            "N/m",
                            "Nm/rad",
                            kFrom0};
const AxisKey kDampingKey{"--damping",
                          "of the coupling, at the device",
                          Dimension::kDamping,
                          Dimension::kRotationalDamping,
                          "Ns/m",
                          "Nms/rad",
                          kFrom0};

void add(Command& command, const AxisKey& key, AxisOptions& options) {
  command
      .option(std::string(key.name) + " VALUE", options.given[key.name],
              std::string(key.help) + ", as \"" + std::string(example_of(key.moving)) +
                  "\", with --turning \"" + std::string(example_of(key.turning)) +
                  "\"; else the session's")
      .expected(1);
}

double parsed(const AxisKey& key, const std::string& text, bool turning) {
  try {
    return parse_quantity(text, turning ? key.turning : key.moving, key.range,
                          turning ? key.turning_unit : key.moving_unit);
  } catch (const QuantityError& error) {
    throw UsageError(std::string(key.name) + ": " + error.what());
  }
}

std::optional<double> value_given(const AxisOptions& options, const AxisKey& key) {
  const auto found = options.given.find(key.name);
  if (found == options.given.end() || found->second.empty()) return std::nullopt;
  return parsed(key, found->second[0], options.turning);
}

/// The device of a session: of a real one what [device] says, in nobody's hand, and nothing is
/// known of its friction and encoders.
Hand hand_of(const SessionConfig& config) {
  Hand hand = config.device.hand;
  if (config.device.kind == DeviceKind::kSimulatedHand) return hand;
  const CoupledAxis moving = moving_axis(config), turning = turning_axis(config);
  hand.mass = moving.mass;
  hand.damping = moving.damping;
  hand.inertia = turning.mass;
  hand.rotational_damping = turning.damping;
  hand.coulomb_friction = hand.rotational_friction = hand.encoder_step = hand.angle_step = 0;
  hand.hand_mass = hand.hand_damping = hand.hand_stiffness = 0;
  hand.hand_inertia = hand.hand_rotational_damping = hand.hand_rotational_stiffness = 0;
  return hand;
}

}  // namespace

void add_axis_options(Command& command, AxisOptions& options) {
  add_config(command, options.config).show_default();
  command.flag("--turning", options.turning,
               "the axis that turns: inertia for mass, torque for force, angles for lengths");
  for (const DeviceKey& key : kDeviceKeys) add(command, key, options);
  command.quantity("--rate", options.rate, Dimension::kFrequency, {20, 1e5},
                   "of the servo, as 1kHz; else the session's", "Hz");
  command.option("-o,--output FILE.svg", options.output, "draws it into this file")
      .check([](const std::string& name) {
        return name.ends_with(".svg") ? "" : "the drawing is an SVG; name it with .svg at the end";
      });
  add_overwrite(command, options.overwrite);
}

void add_coupling_options(Command& command, AxisOptions& options) {
  add(command, kStiffnessKey, options);
  add(command, kDampingKey, options);
}

double damping_of(const std::string& text, bool turning) {
  return parsed(kDampingKey, text, turning);
}

ProbeSetting setting_of(const AxisOptions& options) {
  SessionConfig config = load_config(find_session_file(options.config));
  if (options.rate > 0) config.servo_rate = options.rate;
  Hand hand = hand_of(config);
  for (const DeviceKey& key : kDeviceKeys) {
    if (const auto value = value_given(options, key)) {
      hand.*(options.turning ? key.turning_value : key.moving_value) = *value;
    }
  }
  const CoupledAxis axis = options.turning ? turning_axis(config) : moving_axis(config);
  const auto stiffness = value_given(options, kStiffnessKey),
             damping = value_given(options, kDampingKey);
  if (!((options.turning ? hand.inertia : hand.mass) > 0)) {
    throw UsageError(options.turning ? options.config +
                                           ": the handle cannot turn; give inertia in "
                                           "[device.hand], or --mass \"1e-4 kg·m²\""
                                     : options.config +
                                           ": the mass of the device is not known; give mass in "
                                           "[device], or --mass \"0.1 kg\"");
  }
  return {.turning = options.turning,
          .hand = hand,
          .stiffness = stiffness.value_or(axis.stiffness),
          .damping = damping.value_or(axis.coupling_damping),
          .rate = config.servo_rate,
          .max_damping = config.device.max_damping,
          .max_rotational_damping = config.device.max_rotational_damping};
}

CoupledAxis coupled_axis(const ProbeSetting& s) {
  return {s.turning ? s.hand.inertia : s.hand.mass,
          s.turning ? s.hand.rotational_damping : s.hand.damping, s.stiffness, s.damping,
          1 / s.rate};
}

}  // namespace haptic
