// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/volume/voxel_scan.h"

namespace haptic {

/// What looking up these points costs at least: moves each into the map, gathers its brick and its
/// word, and adds up the words, so that the compiler keeps the loads. No border, no voxel, no hit:
/// every point must be inside the map.
uint32_t gather_bare(const Voxmap& map, const Pointshell& shell, const ShellInVoxels& at,
                     ScanPath path);

}  // namespace haptic
