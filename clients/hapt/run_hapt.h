// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "proto/config/command_line.h"

namespace haptic {

/// Reads the words, does what they say, and returns the exit code. `hapt` and hapt-lab, which are
/// one program to whoever types them, differ in the commands that are added.
int run_hapt(int argc, char** argv, const std::function<void(Command&)>& add_commands);

}  // namespace haptic
