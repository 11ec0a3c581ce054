// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/lab/eval/scenes/workload.h"
#include "clients/lab/support/scan.h"
#include "proto/config/command_line.h"

namespace haptic {

/// Option --size: the longest side of a mesh file.
void add_scan_size(Command& command, double& size);

/// A path through positions at 1 kHz, linear in between; it owns them.
ToolPath path_through(std::vector<Vec3> positions);

/// A path around any mesh: along sphere_direction, at workload_depth below the outermost surface
/// seen from the centre of its box, for a tool of that radius, never faster than the slides. The
/// shape must outlive it.
ToolPath way_around(const MeshShape& shape, double tool_radius, uint64_t ticks);

}  // namespace haptic
