// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "proto/config/command_line.h"

namespace haptic {

/// Facts about the device at a node and the machine, for the report.
using ReportFacts = std::function<std::vector<std::string>(const std::string& node)>;

/// Adds `try` to `hapt devices`; sets `ran` where it was asked for.
void add_try_command(Command& devices, bool& ran, const ReportFacts& facts);

}  // namespace haptic
