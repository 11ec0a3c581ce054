// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/command.h"

#include <charconv>
#include <cmath>

#include "proto/one_line.h"
#include "proto/quantity.h"
#include "proto/renderer.h"

namespace haptic {
namespace {

constexpr const char* kCommands =
    "status, config, stop, clear-fault, arm, disarm, pause, resume, "
    "set stiffness|damping|rotational-stiffness|rotational-damping|time-scale|renderer VALUE";
constexpr double kMostStiffness = 1e5;            // [N/m]
constexpr double kMostDamping = 1e3;              // [N·s/m]
constexpr double kMostRotationalStiffness = 1e3;  // [N·m/rad]
constexpr double kMostRotationalDamping = 10;     // [N·m·s/rad]
constexpr double kMostTimeScale = 10;

Command refused(const std::string& problem) {
  return {CommandKind::kRefused, false, one_line(problem)};
}

/// What was said, for an answer.
std::string quoted(std::string_view text) {
  constexpr size_t kLongest = 60;
  return one_line(std::string(text), kLongest);
}

/// The first word; the rest stays in `line`.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  const std::string_view word = line.substr(0, line.find(' '));
  line.remove_prefix(word.size());
  line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
  return word;
}

double plain_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw QuantityError("'" + std::string(text) + "' is not a number; write for example 0.5");
  }
  return value;
}

/// What this session lacks for a renderer; empty: nothing.
std::string lack_of(const SessionConfig& config, Renderer renderer, const ControlFrame& wanted) {
  if (!is_of_body(renderer)) return "";
  if (view(config.tool.mesh).empty()) {
    return "moves a tool with six degrees of freedom, and this session has a point; add [tool] to "
           "its file";
  }
  const bool has_maps = config.renderer == Renderer::kVoxel || config.voxel.is_wanted != 0;
  if (renderer == Renderer::kVoxel && !has_maps) {
    return "asks maps of voxels, and this session has none; add [contact.voxel] to its file";
  }
  if (!has_springs(config.proxy, renderer)) return "";
  if (wanted.translational_stiffness > 0 && wanted.rotational_stiffness > 0) return "";
  return "has a proxy that moves and turns, and needs stiffness and rotational-stiffness above "
         "zero";
}

Command set_renderer(std::string_view name, const SessionConfig& config, ControlFrame& wanted) {
  std::string known;
  for (const auto& [word, renderer] : kRenderers) {
    known += (known.empty() ? "" : ", ") + std::string(word);
    if (word != name) continue;
    const std::string lack = lack_of(config, renderer, wanted);
    if (!lack.empty()) return refused("renderer: '" + std::string(name) + "' " + lack);
    wanted.renderer = static_cast<uint32_t>(renderer);
    return {CommandKind::kChange, false, ""};
  }
  return refused("renderer: there is no '" + quoted(name) + "'; known: " + known);
}

Command set(std::string_view line, const SessionConfig& config, ControlFrame& wanted) {
  const std::string_view key = take_word(line);
  if (key == "renderer") return set_renderer(line, config, wanted);
  double* target = nullptr;
  double most = 0, value = 0;
  try {
    if (key == "stiffness") {
      target = &wanted.translational_stiffness, most = kMostStiffness;
      value = parse_quantity(line, Dimension::kStiffness);
    } else if (key == "damping") {
      target = &wanted.translational_damping, most = kMostDamping;
      value = parse_quantity(line, Dimension::kDamping);
    } else if (key == "rotational-stiffness") {
      target = &wanted.rotational_stiffness, most = kMostRotationalStiffness;
      value = parse_quantity(line, Dimension::kRotationalStiffness);
    } else if (key == "rotational-damping") {
      target = &wanted.rotational_damping, most = kMostRotationalDamping;
      value = parse_quantity(line, Dimension::kRotationalDamping);
    } else if (key == "time-scale") {
      target = &wanted.scene_time_scale, most = kMostTimeScale;
      value = plain_number(line);
    } else {
      return refused("cannot set '" + quoted(key) +
                     "'; what can be set: stiffness, damping, rotational-stiffness, "
                     "rotational-damping, time-scale, renderer");
    }
  } catch (const QuantityError& error) {
    return refused(std::string(key) + ": " + error.what());
  }
  if (!(value >= 0 && value <= most)) {
    return refused(std::string(key) + ": is out of range; use 0 to " +
                   std::to_string(static_cast<long>(most)) + " (SI)");
  }
  *target = value;
  const std::string lack = lack_of(config, static_cast<Renderer>(wanted.renderer), wanted);
  if (!lack.empty()) return refused(std::string(key) + ": the present renderer " + lack);
  return {CommandKind::kChange, false, ""};
}

}  // namespace

Command apply_command(std::string_view line, const SessionConfig& config, ControlFrame& wanted) {
  const std::string_view word = take_word(line);
  if (word != "set" && !line.empty()) {
    return refused("'" + quoted(word) + "' takes nothing after it");
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
    return refused("unknown command '" + quoted(word) + "'; known: " + kCommands);
  }
  if (command.kind != CommandKind::kChange) return command;
  ++changed.revision;
  wanted = changed;
  return command;
}

}  // namespace haptic
