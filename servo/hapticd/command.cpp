// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/command.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "proto/config/config_warnings.h"
#include "proto/config/devices.h"
#include "proto/config/quantity.h"
#include "proto/config/renderer_needs.h"
#include "proto/os/message.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr const char* kCommands =
    "status, status text, config, stop, clear-fault, arm, disarm, pause, resume, "
    "lead X Y Z, release, "
    "set stiffness|damping|rotational-stiffness|rotational-damping|time-scale|renderer|solver "
    "VALUE";
constexpr double kUnitQuaternion = 1e-3;  // how far a written one may be from length 1

ControlCommand refused(const std::string& problem) {
  return {CommandKind::kRefused, false, one_line(problem), ""};
}

/// Removes the first word from `line` and returns it.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  const std::string_view word = line.substr(0, line.find(' '));
  line.remove_prefix(word.size());
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  return word;
}

/// What the session lacks for a renderer, given the springs of the wanted frame; empty: nothing.
std::string lack_with(const SessionConfig& config, Renderer renderer, const ControlFrame& wanted) {
  const Springs springs{wanted.translational_stiffness, wanted.rotational_stiffness};
  const SoftSolver solver =
      soft_solver_of(wanted.solver).value_or(solver_of(config.proxy, renderer));
  return lack_of(config, renderer, solver, springs, baked_for(config));
}

ControlCommand set_renderer(std::string_view name, const SessionConfig& config,
                            ControlFrame& wanted) {
  const RendererRow* row = find_renderer(name);
  if (row == nullptr) {
    return refused(unknown_renderer(name));
  }
  wanted.renderer = static_cast<uint32_t>(row->id);
  if (row->moves == Moves::kSoftBody) wanted.solver = number_of(solver_of(config.proxy, row->id));
  const std::string lack = lack_with(config, row->id, wanted);
  if (!lack.empty()) return refused("renderer: '" + std::string(name) + "' " + lack);
  return {CommandKind::kChange, false, "", ""};
}

ControlCommand set_solver(std::string_view name, const SessionConfig& config,
                          ControlFrame& wanted) {
  const auto known = std::find(kSoftSolverNames.begin(), kSoftSolverNames.end(), name);
  if (known == kSoftSolverNames.end()) {
    const std::vector<std::string_view> names(kSoftSolverNames.begin(), kSoftSolverNames.end());
    return refused("there is no solver '" + shown(name) + "'; " + suggestion(name, names));
  }
  const RendererRow& renderer = row_of(static_cast<Renderer>(wanted.renderer));
  if (renderer.moves != Moves::kSoftBody) {
    return refused(
        "solver: the present renderer '" + std::string(renderer.name) +
        "' has one of its own; first set renderer voxel, direct6, localized or sensation");
  }
  wanted.solver = number_of(static_cast<SoftSolver>(known - kSoftSolverNames.begin()));
  const std::string lack = lack_with(config, renderer.id, wanted);
  if (!lack.empty())
    return refused("solver: with '" + std::string(name) + "' the renderer " + lack);
  return {CommandKind::kChange, false, "", ""};
}

/// Why the hand of this session cannot be led; empty: it can.
std::string why_not_led(const DeviceConfig& device) {
  const DeviceRow& row = row_of(device.kind);
  if (row.is_recorded) return "the device is a replay: nothing to lead";
  if (!row.can_be_led) return "the device is a real one: nothing to lead, move it by hand";
  if (device.hand.hand_stiffness > 0) return "";
  return "no hand holds the simulated device (hand_stiffness is 0): nothing to lead";
}

ControlCommand lead(std::string_view line, const SessionConfig& config, ControlFrame& wanted) {
  const std::string problem = why_not_led(config.device);
  if (!problem.empty()) return refused("lead: " + problem);
  std::array<double, 7> numbers{0, 0, 0, 1};
  size_t n = 0;
  try {
    for (; !line.empty() && n < numbers.size(); ++n) {
      numbers[n] = parse_number(take_word(line), {-kMostLength, kMostLength});
    }
  } catch (const QuantityError& error) {
    return refused(std::string("lead: ") + error.what());
  }
  const Quat q{numbers[4], numbers[5], numbers[6], numbers[3]};
  if (!line.empty() || (n != 3 && n != 7)) {
    return refused(
        "lead: takes X Y Z of the tool in the scene [m], or X Y Z QW QX QY QZ, as 'lead 0 0 0.05'");
  }
  if (std::fabs(dot(q, q) - 1) > kUnitQuaternion) {
    return refused("lead: QW QX QY QZ is no rotation; its length has to be 1");
  }
  // without an orientation, and where the handle cannot turn: the tool as the handle holds it at
  // rest
  const bool turns = n == 7 && config.device.hand.inertia > 0;
  const Quat at_rest = config.map.X_WB.q * config.map.X_HT.q;
  wanted.X_WT_intent = {{numbers[0], numbers[1], numbers[2]}, turns ? normalized(q) : at_rest};
  wanted.leading = 1;
  return {CommandKind::kLead, false, "", ""};
}

ControlCommand release(const SessionConfig& config, ControlFrame& wanted) {
  const std::string problem = why_not_led(config.device);
  if (!problem.empty()) return refused("release: " + problem);
  wanted.leading = 0;
  return {CommandKind::kLead, false, "", ""};
}

/// A settable number; `most` is its largest value in SI units.
struct Parameter {
  std::string_view name;
  double ControlFrame::*target;
  double most;
  std::optional<Dimension> dimension;  // none: a plain number
};
constexpr std::array<Parameter, 5> kParameters{
    {{"stiffness", &ControlFrame::translational_stiffness, 1e5, Dimension::kStiffness},
     {"damping", &ControlFrame::translational_damping, 1e3, Dimension::kDamping},
     {"rotational-stiffness", &ControlFrame::rotational_stiffness, 1e3,
      Dimension::kRotationalStiffness},
     {"rotational-damping", &ControlFrame::rotational_damping, 10, Dimension::kRotationalDamping},
     {"time-scale", &ControlFrame::scene_time_scale, 10, std::nullopt}}};

double parse_value(std::string_view text, const Parameter& parameter) {
  const Range range{0, parameter.most};
  return parameter.dimension ? parse_quantity(text, *parameter.dimension, range)
                             : parse_number(text, range);
}

ControlCommand set(std::string_view line, const SessionConfig& config, ControlFrame& wanted) {
  const std::string_view key = take_word(line);
  if (key == "renderer") return set_renderer(line, config, wanted);
  if (key == "solver") return set_solver(line, config, wanted);
  const auto parameter = std::find_if(kParameters.begin(), kParameters.end(),
                                      [&](const Parameter& p) { return p.name == key; });
  if (parameter == kParameters.end()) {
    std::vector<std::string_view> known{"renderer", "solver"};
    for (const Parameter& each : kParameters) known.push_back(each.name);
    return refused("cannot set '" + shown(key) + "'; " + suggestion(key, known));
  }
  try {
    wanted.*parameter->target = parse_value(line, *parameter);
  } catch (const QuantityError& error) {
    return refused(std::string(key) + ": " + error.what());
  }
  const std::string lack = lack_with(config, static_cast<Renderer>(wanted.renderer), wanted);
  if (!lack.empty()) return refused(std::string(key) + ": the present renderer " + lack);
  return {CommandKind::kChange, false, "", ""};
}

/// The session as it would be.
SessionConfig changed_by(const ControlFrame& wanted, SessionConfig config) {
  config.coupling = {wanted.translational_stiffness, wanted.translational_damping,
                     wanted.rotational_stiffness, wanted.rotational_damping};
  config.renderer = static_cast<Renderer>(wanted.renderer);
  if (const auto solver = soft_solver_of(wanted.solver)) config.proxy.solver = *solver;
  return config;
}

/// A change that was understood, unless the device could not hold it.
ControlCommand held(const ControlFrame& before, const ControlFrame& wanted,
                    const SessionConfig& config, bool is_forced) {
  const SessionConfig now = changed_by(before, config), changed = changed_by(wanted, config);
  const std::string beyond = too_stiff(changed, &now);
  if (!beyond.empty() && !is_forced) return refused(beyond);
  ControlCommand command{CommandKind::kChange, false, "", ""};
  const std::vector<std::string> known = config_warnings(now);
  for (const std::string& line : config_warnings(changed)) {
    if (std::find(known.begin(), known.end(), line) != known.end()) continue;
    command.warning += (command.warning.empty() ? "" : "; ") + line;
  }
  return command;
}

ControlCommand set_and_check(std::string_view line, const SessionConfig& config,
                             ControlFrame& wanted) {
  constexpr std::string_view kForce = " --force";
  const bool is_forced = line.ends_with(kForce);
  if (is_forced) line.remove_suffix(kForce.size());
  const ControlFrame before = wanted;
  const ControlCommand command = set(line, config, wanted);
  return command.kind == CommandKind::kChange ? held(before, wanted, config, is_forced) : command;
}

}  // namespace

ControlCommand apply_command(std::string_view line, const SessionConfig& config,
                             ControlFrame& wanted) {
  const std::string_view word = take_word(line);
  if (word == "status" && line == "text") return {CommandKind::kStatusText, false, "", ""};
  if (word != "set" && word != "lead" && !line.empty()) {
    return refused("'" + shown(word) + "' takes nothing after it");
  }
  ControlFrame changed = wanted;
  ControlCommand command{CommandKind::kChange, false, "", ""};
  if (word == "status") return {CommandKind::kStatus, false, "", ""};
  if (word == "config") return {CommandKind::kConfig, false, "", ""};
  if (word == "stop") return {CommandKind::kStop, false, "", ""};
  if (word == "clear-fault") {
    ++changed.fault_clears;
    changed.fault = 0;
    command.clears_fault = true;
  } else if (word == "arm" || word == "disarm") {
    changed.armed = word == "arm" ? 1 : 0;
  } else if (word == "pause" || word == "resume") {
    changed.paused = word == "pause" ? 1 : 0;
  } else if (word == "set") {
    command = set_and_check(line, config, changed);
  } else if (word == "lead") {
    command = lead(line, config, changed);
  } else if (word == "release") {
    command = release(config, changed);
  } else {
    return refused("unknown command '" + shown(word) + "'; known: " + kCommands);
  }
  if (command.kind != CommandKind::kChange && command.kind != CommandKind::kLead) return command;
  ++changed.revision;
  wanted = changed;
  return command;
}

}  // namespace haptic
