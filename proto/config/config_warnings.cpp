// SPDX-License-Identifier: Apache-2.0
#include "proto/config/config_warnings.h"

#include <algorithm>

#include "proto/config/coupling_margin.h"
#include "proto/config/devices.h"
#include "proto/config/renderer_needs.h"
#include "proto/os/text.h"
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

/// An axis as it is felt at the device.
struct FeltAxis {
  CoupledAxis axis;
  AxisWords words;
  bool is_coupling = true;
};

/// How far a stiffness is above the most that may be asked for.
double excess(const CoupledAxis& axis) {
  return axis.stiffness - kMostBeyond * passive_stiffness(axis);
}

std::vector<FeltAxis> felt_axes(const SessionConfig& config) {
  std::vector<FeltAxis> axes;
  // a replay has no hand in the loop and cannot oscillate
  if (row_of(config.device.kind).is_recorded) return axes;
  const bool is_direct = is_of_body(config.renderer) && !has_springs(config.proxy, config.renderer);
  CoupledAxis linear = moving_axis(config);
  if (!is_direct) {
    axes.push_back({linear, kLinear});
  } else {
    // without a coupling the hand feels the contacts' own stiffness
    const bool by_points = row_of(config.renderer).has_maps;
    const double gain = config.map.motion_scale * config.map.force_scale;
    linear.stiffness =
        gain * (by_points ? kSharing * config.voxel.stiffness : config.proxy.contact_stiffness);
    linear.coupling_damping = 0;
    axes.push_back({linear, by_points ? kPoints : kContact, false});
  }
  if (config.device.max_torque > 0 && !is_direct && can_turn(config.device)) {
    axes.push_back({turning_axis(config), kAngular});
  }
  std::erase_if(axes, [](const FeltAxis& felt) {
    return !(felt.axis.damping > 0) || felt.axis.stiffness == 0;
  });
  return axes;
}

/// "stiffness in [coupling] is 800 N/m at the device, whose own damping is 0.5 N·s/m"
std::string words_of(const FeltAxis& felt) {
  return formatted("%s is %.5g %s at the device, whose own damping is %.5g %s",
                   felt.words.stiffness, felt.axis.stiffness, felt.words.stiffness_unit,
                   felt.axis.damping, felt.words.damping_unit);
}

/// How the stiffness, the damping or the rate would have to change.
std::string mend_of(const FeltAxis& felt) {
  return std::string("lower it, or ") + felt.words.damping + ", or raise rate in [servo]";
}

void check_axis(const FeltAxis& felt, std::vector<std::string>& lines) {
  const double most = passive_stiffness(felt.axis), margin = two_port_margin(felt.axis);
  const bool is_beyond = felt.axis.stiffness >= most;
  if (!is_beyond && !(margin < 0)) return;
  lines.push_back(
      words_of(felt) + ": " +
      (is_beyond ? formatted("passive is less than 2 (b - b_c)/T = %.5g %s (two-port margin %.5g)",
                             most, felt.words.stiffness_unit, margin)
                 : formatted("its two-port margin is %.5g, below zero", margin)) +
      ", and it may sing in a light hand; " + mend_of(felt));
}

}  // namespace

std::vector<std::string> config_warnings(const SessionConfig& config) {
  std::vector<std::string> lines;
  for (const FeltAxis& felt : felt_axes(config)) check_axis(felt, lines);
  if (config.device.max_torque > 0 && !can_turn(config.device)) {
    lines.push_back(
        "max_torque in [device] has no effect: the simulated hand's handle cannot turn; give "
        "inertia in [device.hand], as \"1e-4 kg·m²\"");
  }
  return lines;
}

std::string too_stiff(const SessionConfig& config, const SessionConfig* held) {
  const std::vector<FeltAxis> before = held != nullptr ? felt_axes(*held) : std::vector<FeltAxis>{};
  for (const FeltAxis& felt : felt_axes(config)) {
    // of contacts that are felt directly only the stiffness of one is known
    if (!felt.is_coupling || !is_far_beyond(felt.axis)) continue;
    const bool is_held = std::ranges::any_of(before, [&](const FeltAxis& b) {
      return b.words.stiffness == felt.words.stiffness && excess(b.axis) >= excess(felt.axis);
    });
    if (is_held) continue;
    return words_of(felt) +
           formatted(": more than twice what it holds, 2 (b - b_c)/T = %.5g %s; ",
                     passive_stiffness(felt.axis), felt.words.stiffness_unit) +
           mend_of(felt) + " (hapticd and hapt set take --force)";
  }
  return "";
}

}  // namespace haptic
