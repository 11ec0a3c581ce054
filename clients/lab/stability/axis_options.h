// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>
#include <vector>

#include "clients/lab/stability/probe.h"
#include "proto/config/command_line.h"

namespace haptic {

/// Units of the axis that is looked at.
struct AxisUnits {
  const char *stiffness, *damping, *place;
};
constexpr AxisUnits units_of(bool turning) {
  return turning ? AxisUnits{"N·m/rad", "N·m·s/rad", "rad"} : AxisUnits{"N/m", "N·s/m", "m"};
}

/// Which axis of which device: options that the commands of the stability laboratory share. A value
/// that is given on the command line replaces that of the session file; it is a quantity of moving
/// or, with --turning, of turning.
struct AxisOptions {
  std::string config = "plane.toml";
  bool turning = false;
  std::map<std::string, std::vector<std::string>> given;  // by name of the option: its word, if any
  double rate = 0;                                        // [Hz]; 0: the session's
  std::string output;                                     // an SVG
  bool overwrite = false;
};

/// Adds --config, --turning, those of the device, --rate, and those of the output.
void add_axis_options(Command& command, AxisOptions& options);
/// Adds --stiffness and --damping of the coupling.
void add_coupling_options(Command& command, AxisOptions& options);

/// The axis of the session, its device, hand and coupling as they are felt at the handle. Throws
/// InputError in one line: a quantity is wrong, or the device's mass is not known.
ProbeSetting setting_of(const AxisOptions& options);

/// A damping of the coupling as typed. Throws UsageError.
double damping_of(const std::string& text, bool turning);

/// Axis of that setting without the hand, as the two-port has it.
CoupledAxis coupled_axis(const ProbeSetting& setting);

}  // namespace haptic
