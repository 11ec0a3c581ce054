// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "proto/config/command_line.h"

namespace haptic {

/// Parses the arguments, runs the command and returns the exit code. `hapt` and hapt-lab, which
/// look like one program to the user, differ only in the commands that are added.
int run_hapt(int argc, char** argv, const std::function<void(Command&)>& add_commands);

}  // namespace haptic
