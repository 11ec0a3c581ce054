// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/volume/voxel_scan.h"

namespace haptic {

/// Least cost of looking up these points: transforms each into the map, gathers its brick and word,
/// and adds up the words, so that the compiler keeps the loads. No border test, no voxel test, no
/// hits: every point must be inside the map.
uint32_t gather_bare(const Voxmap& map, const Pointshell& shell, const ShellInVoxels& at,
                     ScanPath path);

}  // namespace haptic
