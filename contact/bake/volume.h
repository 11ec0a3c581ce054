// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "contact/bake/bake.h"
#include "contact/shape/baked/volume.h"

namespace haptic {

/// Data of a body for the detector `voxel`, kept alive by its storage (a mapped cache file or
/// memory).
struct BakedVolume {
  VolumeContent content;
  bool from_cache = false;
  double map_time = 0, field_time = 0, shell_time = 0;  // time of baking in this run [s]
  std::vector<std::string> lines;                       // about the cache, for people
  std::shared_ptr<const void> storage;
};

/// Map of an object and, with options.field, its field; from the cache folder if they were baked
/// before (key: triangles, options, version), else on two threads. A mesh that is not closed has no
/// inside: with options.open_as_sheet it becomes a sheet, one voxel thick in the field (φ =
/// distance − size/2). Throws MeshError if it is not closed without that option, and if it needs
/// more voxels along a side than a map can have.
BakedVolume bake_obstacle(const BakedShape& shape, const VoxelConfig& options,
                          const BakeProgress& progress = {});

/// Point shell of the tool, with options.point_spacing; cached like the map. Throws MeshError if
/// that spacing is too fine.
BakedVolume bake_tool(const BakedShape& shape, const VoxelConfig& options,
                      const BakeProgress& progress = {});

}  // namespace haptic
