// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/baked/block.h"
#include "contact/shape/volume/distance_field.h"
#include "contact/shape/volume/pointshell.h"
#include "contact/shape/volume/voxmap.h"

namespace haptic {

/// Data of the detector `voxel` for a body: map and field of an object, shell of the tool. Missing
/// parts are empty.
struct VolumeContent {
  Voxmap map;
  DistanceField field;
  Pointshell shell;
};

std::vector<std::byte> write_volume(const VolumeContent& content, uint64_t key);

/// Views a block in place; nothing is parsed or copied. Checks that every voxel and node has its
/// brick, and that every node of the shell has its points and, after it, its children, level by
/// level: queries on a checked file cannot leave the arrays. `bytes` must be 8-byte aligned. Throws
/// BakedFileError.
VolumeContent view_volume(std::span<const std::byte> bytes, uint64_t key,
                          const RunBoth& run_both = run_in_turn);

}  // namespace haptic
