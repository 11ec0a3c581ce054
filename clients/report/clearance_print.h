// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ostream>
#include <string>

#include "clients/report/clearance.h"

namespace haptic {

/// For people: the least distance to each object with its time and place, and the least in each
/// tenth of the time.
void print_clearance(std::ostream& out, const std::string& log, const SessionConfig& config,
                     const Clearance& clearance);

/// One object with every sample: {log, poses, proven, objects: [{name, index, distance_m, meets,
/// tick, t_s, tool_point_W, object_point_W, X_WT, X_WO}], nearest: index in objects, samples:
/// [{tick, t_s, distance_m: [of each object]}]}. A pose is {position, orientation: [w, x, y, z]}.
void print_clearance_json(std::ostream& out, const std::string& log, const SessionConfig& config,
                          const Clearance& clearance);

/// The distances over time, once in full and once near the tightest places, which are marked.
/// Throws std::runtime_error if the file cannot be written.
void plot_clearance(const std::string& path, const std::string& log, const SessionConfig& config,
                    const Clearance& clearance);

}  // namespace haptic
