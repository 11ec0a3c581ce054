// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/eval/scenes/workload.h"
#include "contact/bake/bake.h"

namespace haptic {

/// A scan from a file, sized so that its longest side is `size` [m]; open ones are one-sided
/// surfaces. Throws MeshError.
BakedShape bake_scan(const std::string& file, double size);

/// Positions at 1 kHz as a path, straight in between; holds copies.
ToolPath path_through(std::vector<Vec3> positions);

/// The way around any mesh: along sphere_direction, at workload_depth under the outermost surface
/// seen from the middle of its box, never faster than the slides, for a tool of that radius. The
/// shape must outlive it.
ToolPath way_around(const MeshShape& shape, double tool_radius, uint64_t ticks);

}  // namespace haptic
