// SPDX-License-Identifier: GPL-3.0-or-later
// hapt devices weigh: the masses of an arm that its motors are to hold up.
#include "clients/desk/trial/weigh_command.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>

#include "clients/desk/trial/asking.h"
#include "device-io/plugged/find_node.h"
#include "proto/ipc/process.h"
#include "proto/os/message.h"
#include "proto/os/priorities.h"
#include "proto/os/text.h"
#include "servo/model.h"

namespace haptic {
namespace {

constexpr double kSoft = 200;       // most of the spring [N/m]: 1 N at 5 mm
constexpr double kMostDamping = 2;  // [N·s/m]
constexpr double kTurning = 0.2;    // of the handle [N·m/rad]
// residual by weight and friction; above it something else pulls
constexpr double kWellWeighed = 0.1;

size_t links_of(const DeviceRow& device) {
  const auto none = std::ranges::find(device.links, std::string_view{});
  return static_cast<size_t>(none - device.links.begin()) - 1;
}

WeighPlan plan_of(const SessionConfig& config, const DeviceCaps& caps, const SafetyLimits& limits) {
  WeighPlan plan;
  plan.centre_B = config.device.workspace_centre_B;
  plan.radius = config.device.workspace_radius;
  plan.is_planar = caps.is_planar;
  plan.stiffness = std::min(kSoft, config.coupling.translational_stiffness);
  plan.damping = std::min(kMostDamping, config.device.max_damping);
  plan.force = weighing_limits(limits).max_force;
  plan.turning = limits.max_torque > 0 ? kTurning : 0;
  plan.down_B = config.device.gravity.down_B;
  plan.n_links = links_of(row_of(config.device.kind));
  return plan;
}

SessionConfig weighed_config(const TriedDevice& tried) {
  SessionConfig config = config_of(tried);
  const DeviceRow& device = row_of(config.device.kind);
  if (device.links[0].empty()) {
    throw InputError(std::string(device.name) + " has no motors that hold up an arm; leave it");
  }
  if (!(config.device.workspace_radius > 0)) {
    throw InputError(shown(tried.what) +
                     ": says not where the arm may be led; give a session file with "
                     "workspace_radius in [device]");
  }
  return config;
}

/// Says what came of it; true if a table is worth pasting.
bool show(const DeviceRow& device, const Weighing& weighing) {
  const WeightFit fit = weighing.fit();
  std::cout << formatted("weighed in %zu places: %.3g to %.3g N at the handle\n",
                         weighing.places().size(), fit.least_weight, fit.most_weight)
            << formatted("friction: %.3g N, at most %.3g N; it is not compensated\n", fit.friction,
                         fit.most_friction)
            << formatted("residual: %.3g N, at most %.3g N\n", fit.residual, fit.largest_residual);
  const bool is_told = fit.residual <= kWellWeighed * (fit.most_weight + fit.friction);
  if (!is_told) {
    std::cout << "this table does not explain the weight: is a cable pulling, a stand in its way, "
                 "`down` wrong, or its friction uneven?\n";
  }
  std::cout << "\nfor the session file:\n\n"
            << gravity_block(fit.gravity, device.links) << std::flush;
  return is_told;
}

void weigh(const TriedDevice& tried) {
  check_terminal(tried.yes);
  const SessionConfig config = weighed_config(tried);
  const DeviceRow& row = row_of(config.device.kind);
  catch_stop_signals();
  const auto device = open_device(config.device, open_node(config.device));
  const DeviceCaps caps = device->caps();
  const SafetyLimits limits =
      build_servo_model(config, {caps.max_force, caps.max_torque, false}).limits;
  std::cout << one_line(device->description()) << '\n';
  enter_realtime({.fifo_priority = config.realtime != 0 ? kServoPriority : 0});
  TrialRun run(*device, limits, config.servo_rate);
  if (!is_agreed(&run, tried.yes,
                 formatted("Let the handle lie where it rests by itself, hands off, nothing in its "
                           "way. For a minute and a half it is led about with at most %.2g N; "
                           "touch it, and it ends. Go on?",
                           weighing_limits(limits).max_force))) {
    return;
  }
  Weighing weighing(plan_of(config, caps, limits),
                    [&](const GravityConfig& gravity) { return device->holding(gravity); });
  size_t shown = 0;
  const std::string ended = run.weigh(weighing, [&] {
    if (weighing.places().size() == shown) return;
    const WeighedPlace& place = weighing.places()[shown++];
    std::printf("  place %zu of %zu: %.3f N, friction %.3f N\n", shown, Weighing::kPlaces,
                norm(place.weight_B), place.friction);
    std::fflush(stdout);
  });
  if (!ended.empty()) {
    std::cout << "ended: " << ended << "; begin again with the arm at rest\n";
    throw ExitCode{kExitFailed};
  }
  if (!show(row, weighing)) throw ExitCode{kExitFailed};
}

}  // namespace

void add_weigh_command(Command& devices, bool& ran) {
  const auto tried = std::make_shared<TriedDevice>();
  Command command = devices.subcommand(
      "weigh", "Weigh an arm that nobody holds, for [device.gravity]: led about softly for 90 s");
  add_tried_device(command, *tried, "CONFIG", "session file with the device");
  command.example("hapt devices weigh configs/woodenhaptics.toml");
  command.action([tried, &ran] {
    ran = true;
    weigh(*tried);
  });
}

}  // namespace haptic
