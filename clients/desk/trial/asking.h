// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "clients/desk/trial/trial_run.h"
#include "proto/config/command_line.h"
#include "proto/config/config.h"

namespace haptic {

/// The device that a command is to move, as it was typed.
struct TriedDevice {
  std::string what, path;  // kind or session file; serial port
  bool yes = false;        // nothing is asked
};

/// Adds the word that names it, written like this, and --path and --yes.
void add_tried_device(Command& command, TriedDevice& device, const std::string& name,
                      const std::string& help);

/// Its session file, or the defaults of its kind. Throws InputError where there is nothing to move.
SessionConfig config_of(const TriedDevice& device);

/// Throws UsageError without a terminal to ask at.
void check_terminal(bool yes);

/// Asks at the terminal while the device is kept without force.
bool is_agreed(TrialRun* run, bool yes, const std::string& question);

}  // namespace haptic
