// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "contact/bake/bake.h"
#include "contact/shape/baked/volume.h"

namespace haptic {

/// Told what is being made and which share of it is done, from 0 to 1.
using BakeProgress = std::function<void(std::string_view what, double share)>;

/// What the detector `voxel` needs of a body, kept alive by its storage (a mapped cache file or
/// memory).
struct BakedVolume {
  VolumeContent content;
  bool from_cache = false;
  double map_time = 0, field_time = 0, shell_time = 0;  // that baking took now [s]
  std::vector<std::string> lines;                       // about the cache, for people
  std::shared_ptr<const void> storage;
};

/// An object's map, and its field where options.field says so; from the cache folder when they were
/// baked before (key: triangles, options, version), else on two threads. A mesh that is not closed
/// has no inside: with options.open_as_sheet it becomes a sheet, a voxel thick in the field (φ =
/// distance − size/2). Throws MeshError for one that is not closed without that, and for more
/// voxels along a side than a map holds.
BakedVolume bake_obstacle(const BakedShape& shape, const VoxelConfig& options,
                          const BakeProgress& progress = {});

/// The tool's shell of points, options.point_spacing apart; cached like the map. Throws MeshError
/// where that is too fine.
BakedVolume bake_tool(const BakedShape& shape, const VoxelConfig& options,
                      const BakeProgress& progress = {});

}  // namespace haptic
