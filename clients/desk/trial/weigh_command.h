// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/command_line.h"

namespace haptic {

/// Adds `weigh` to `hapt devices`; sets `ran` where it was asked for.
void add_weigh_command(Command& devices, bool& ran);

}  // namespace haptic
