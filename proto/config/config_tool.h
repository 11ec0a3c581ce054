// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "proto/config/config.h"
#include "proto/config/config_section.h"

namespace haptic {

/// Of a voxel, and between the points of a tool [m].
inline constexpr Range kVoxelSizes{1e-5, 0.1};

/// How far from the surface a field may be stored [m]: it is read by cells, so it must reach one
/// beyond the layer of force.
Range band_range(const VoxelConfig& voxel);

/// Reads [tool]. Throws ConfigError.
void read_tool(Section& root, const std::filesystem::path& config_folder, ToolConfig& tool);

/// Reads [proxy]. Throws ConfigError.
void read_proxy(Section& root, ProxyConfig& proxy);

/// Reads [contact.voxel]. Throws ConfigError.
void read_voxel(Section& contact, VoxelConfig& voxel);

/// Reads [contact.rigid]. Throws ConfigError.
void read_rigid(Section& contact, RigidConfig& rigid);

}  // namespace haptic
