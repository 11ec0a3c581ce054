// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "clients/report/summary.h"

namespace haptic {

/// Plots force at the device, depth of the hand behind the surface and wake-up lateness over time
/// as SVG. Throws std::runtime_error if the file cannot be written.
void plot_session(const std::string& path, const std::string& title, const SessionData& data);

}  // namespace haptic
