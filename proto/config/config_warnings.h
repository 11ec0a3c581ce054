// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "proto/config/config.h"

namespace haptic {

/// Warnings about a session, one line each: "what; how to mend". Today: a coupling that can make a
/// lightly held device oscillate. Per axis, in device units, with the numbers:
///   k_c ≥ 2 (b − b_c)/T          (Colgate, Stanley, Brown 1995)
///   two-port margin below zero    (Adams & Hannaford 1999)
/// Silent if the device's damping and mass are unknown; for a real device [device] states them.
std::vector<std::string> config_warnings(const SessionConfig& config);

/// Why a session is refused unless it is forced, one line with the figures: the stiffness of its
/// coupling is, on an axis, far beyond what the device holds (is_far_beyond). Empty: it is not, or
/// `held`, what was forced before, was as far beyond on that axis.
std::string too_stiff(const SessionConfig& config, const SessionConfig* held = nullptr);

}  // namespace haptic
