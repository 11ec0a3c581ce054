// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/baked/block.h"
#include "contact/shape/volume/distance_field.h"
#include "contact/shape/volume/pointshell.h"
#include "contact/shape/volume/voxmap.h"

namespace haptic {

/// What the detector `voxel` needs of a body: of an object the map and the field, of the tool the
/// shell. What is not there is empty.
struct VolumeContent {
  Voxmap map;
  DistanceField field;
  Pointshell shell;
};

/// One block of all arrays.
std::vector<std::byte> write_volume(const VolumeContent& content, uint64_t key);

/// Views a block in place; nothing is parsed or copied. Checks that every voxel and node has its
/// brick and every node of the shell its points and children, which come after it, level by level:
/// a query on what passed cannot leave the arrays. `bytes` must be 8-byte aligned. Throws
/// BakedFileError.
VolumeContent view_volume(std::span<const std::byte> bytes, uint64_t key,
                          const RunBoth& run_both = run_in_turn);

}  // namespace haptic
