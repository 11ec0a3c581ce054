// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "proto/config/config.h"

namespace haptic {

/// What a session may do that nobody wants, one line each: "what; how to mend". Today: a coupling
/// that can make a device in a light hand sing. For each axis, in device units, with the numbers:
///   k_c ≥ 2 (b − b_c)/T          (Colgate, Stanley, Brown 1995)
///   two-port margin below zero    (Adams & Hannaford 1999)
/// Silent where a device's own damping and mass are not known: [device] says them of a real one.
std::vector<std::string> config_warnings(const SessionConfig& config);

}  // namespace haptic
