// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/command.h"

#include <algorithm>
#include <array>
#include <optional>

#include "proto/config/quantity.h"
#include "proto/config/renderer_needs.h"
#include "proto/os/message.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr const char* kCommands =
    "status, status text, config, stop, clear-fault, arm, disarm, pause, resume, "
    "set stiffness|damping|rotational-stiffness|rotational-damping|time-scale|renderer VALUE";

Command refused(const std::string& problem) {
  return {CommandKind::kRefused, false, one_line(problem)};
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
  const bool has_maps = row_of(config.renderer).has_maps || config.voxel.is_wanted != 0;
  return lack_of(config, renderer, springs, has_maps);
}

Command set_renderer(std::string_view name, const SessionConfig& config, ControlFrame& wanted) {
  const RendererRow* row = find_renderer(name);
  if (row == nullptr) {
    return refused(unknown_renderer(name));
  }
  const std::string lack = lack_with(config, row->id, wanted);
  if (!lack.empty()) return refused("renderer: '" + std::string(name) + "' " + lack);
  wanted.renderer = static_cast<uint32_t>(row->id);
  return {CommandKind::kChange, false, ""};
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

Command set(std::string_view line, const SessionConfig& config, ControlFrame& wanted) {
  const std::string_view key = take_word(line);
  if (key == "renderer") return set_renderer(line, config, wanted);
  const auto parameter = std::find_if(kParameters.begin(), kParameters.end(),
                                      [&](const Parameter& p) { return p.name == key; });
  if (parameter == kParameters.end()) {
    std::vector<std::string_view> known{"renderer"};
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
  return {CommandKind::kChange, false, ""};
}

}  // namespace

Command apply_command(std::string_view line, const SessionConfig& config, ControlFrame& wanted) {
  const std::string_view word = take_word(line);
  if (word == "status" && line == "text") return {CommandKind::kStatusText, false, ""};
  if (word != "set" && !line.empty()) {
    return refused("'" + shown(word) + "' takes nothing after it");
  }
  ControlFrame changed = wanted;
  Command command{CommandKind::kChange, false, ""};
  if (word == "status") return {CommandKind::kStatus, false, ""};
  if (word == "config") return {CommandKind::kConfig, false, ""};
  if (word == "stop") return {CommandKind::kStop, false, ""};
  if (word == "clear-fault") {
    ++changed.fault_clears;
    changed.fault = 0;
    command.clears_fault = true;
  } else if (word == "arm" || word == "disarm") {
    changed.armed = word == "arm" ? 1 : 0;
  } else if (word == "pause" || word == "resume") {
    changed.paused = word == "pause" ? 1 : 0;
  } else if (word == "set") {
    command = set(line, config, changed);
  } else {
    return refused("unknown command '" + shown(word) + "'; known: " + kCommands);
  }
  if (command.kind != CommandKind::kChange) return command;
  ++changed.revision;
  wanted = changed;
  return command;
}

}  // namespace haptic
