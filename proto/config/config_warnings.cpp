// SPDX-License-Identifier: Apache-2.0
#include "proto/config/config_warnings.h"

#include <sstream>

#include "proto/config/coupling_margin.h"
#include "proto/config/devices.h"
#include "proto/config/renderer_needs.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kSharing = 10;  // assumed number of points in contact at once

/// Names and units of an axis in messages.
struct AxisWords {
  const char *stiffness, *damping;            // keys of [coupling]
  const char *stiffness_unit, *damping_unit;  // of both
};
constexpr AxisWords kLinear{"stiffness in [coupling]", "damping", "N/m", "N·s/m"};
constexpr AxisWords kContact{"contact_stiffness in [proxy]", "damping", "N/m", "N·s/m"};
constexpr AxisWords kPoints{"ten points' stiffness in [contact.voxel]", "damping", "N/m", "N·s/m"};
constexpr AxisWords kAngular{"rotational_stiffness in [coupling]", "rotational_damping", "N·m/rad",
                             "N·m·s/rad"};

void check_axis(const CoupledAxis& axis, const AxisWords& words, std::vector<std::string>& lines) {
  if (!(axis.damping > 0) || axis.stiffness == 0) return;
  const double most = passive_stiffness(axis);
  std::ostringstream text;
  text.precision(5);
  text << words.stiffness << " is " << axis.stiffness << " " << words.stiffness_unit
       << " at the device, whose own damping is " << axis.damping << " " << words.damping_unit
       << ": ";
  const double margin = two_port_margin(axis);
  if (axis.stiffness >= most) {
    text << "passive is less than 2 (b - b_c)/T = " << most << " " << words.stiffness_unit
         << " (two-port margin " << margin << ")";
  } else if (margin < 0) {
    text << "its two-port margin is " << margin << ", below zero";
  } else {
    return;
  }
  text << ", and it may sing in a light hand; lower it, or " << words.damping
       << ", or raise rate in [servo]";
  lines.push_back(text.str());
}

}  // namespace

std::vector<std::string> config_warnings(const SessionConfig& config) {
  std::vector<std::string> lines;
  // a replay has no hand in the loop and cannot oscillate
  if (row_of(config.device.kind).is_recorded) return lines;
  const bool is_direct = is_of_body(config.renderer) && !has_springs(config.proxy, config.renderer);
  CoupledAxis linear = moving_axis(config);
  if (!is_direct) {
    check_axis(linear, kLinear, lines);
  } else {
    // without a coupling the hand feels the contacts' own stiffness
    const bool by_points = row_of(config.renderer).has_maps;
    const double gain = config.map.motion_scale * config.map.force_scale;
    linear.stiffness =
        gain * (by_points ? kSharing * config.voxel.stiffness : config.proxy.contact_stiffness);
    linear.coupling_damping = 0;
    check_axis(linear, by_points ? kPoints : kContact, lines);
  }
  const bool is_held_still =
      config.device.kind == DeviceKind::kSimulatedHand && !(config.device.hand.inertia > 0);
  if (config.device.max_torque > 0 && is_held_still) {
    lines.push_back(
        "max_torque in [device] has no effect: the simulated hand's handle cannot turn; give "
        "inertia in [device.hand], as \"1e-4 kg·m²\"");
  } else if (config.device.max_torque > 0 && !is_direct) {
    check_axis(turning_axis(config), kAngular, lines);
  }
  return lines;
}

}  // namespace haptic
