// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "proto/config/command_line.h"
#include "proto/wire/hands.h"

/// Options that several commands have, in the same words.
namespace haptic {

/// A duration above zero, at most a month [s]; a bare number is in seconds.
inline Option add_duration(Command& command, const std::string& name, double& seconds,
                           const std::string& help) {
  constexpr double kMonth = 31 * 86400.0;
  return command.quantity(name, seconds, Dimension::kTime, {0, kMonth, true},
                          help + ", as 20s, \"1.5 min\" or 1h", "s");
}

inline Option add_config(Command& command, std::string& config) {
  return command.option("--config FILE", config, "session file, by path or by name");
}

inline Option add_json(Command& command, bool& json) {
  return command.flag("--json", json, "for scripts: JSON on standard output");
}

/// Default rate of the ROS messages that a recorder writes beside its own records.
inline constexpr double kStandardRate = 60;  // [Hz]; what a screen shows
inline Option add_standard_rate(Command& command, double& rate) {
  return command
      .number("--standard-rate", rate, {0, 1000},
              "poses, wrench and transforms a second as messages of ROS, for Foxglove and "
              "Lichtblick; 0: none")
      .show_default("60");
}

/// Which hand of a session or a recording, by its number.
inline Option add_hand(Command& command, uint32_t& hand) {
  return command.option("--hand N", hand, "which hand, from 0 on")
      .range(kFirstHand, kMostHands - 1)
      .show_default();
}

inline Option add_overwrite(Command& command, bool& overwrite) {
  return command.flag("--overwrite", overwrite, "replace output files that exist");
}

/// An option that names an SVG, as "--plot FILE.svg".
inline Option add_drawing(Command& command, const std::string& name, std::string& file,
                          const std::string& help) {
  return command.option(name, file, help).check([](const std::string& typed) {
    return typed.ends_with(".svg") ? "" : "the drawing is an SVG; name it with .svg at the end";
  });
}

inline Option add_plot(Command& command, std::string& plot,
                       const std::string& help = "draw force, depth and lateness into this file") {
  return add_drawing(command, "--plot FILE.svg", plot, help);
}

}  // namespace haptic
