// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "proto/config/read/config_section.h"
#include "proto/config/session_config.h"

namespace haptic {

/// Range of voxel sizes and of the spacing of a tool's points [m].
inline constexpr Range kVoxelSizes{1e-5, 0.1};

/// Range of a field's band [m]: it is sampled by cells, so it must extend one cell beyond the force
/// layer.
Range band_range(const VoxelConfig& voxel);

/// Reads [tool]. Throws ConfigError.
void read_tool(Section& root, const std::filesystem::path& config_folder, ToolConfig& tool);

/// Reads [proxy]. Throws ConfigError.
void read_proxy(Section& root, ProxyConfig& proxy);

/// Reads [contact.voxel]. Throws ConfigError.
void read_voxel(Section& contact, VoxelConfig& voxel);

/// Reads [contact.pieces]. Throws ConfigError.
void read_pieces(Section& contact, PieceConfig& pieces);

/// Reads [contact.rigid]. Throws ConfigError.
void read_rigid(Section& contact, RigidConfig& rigid);

/// Throws ConfigError where the solver of [contact.rigid] lacks what the objects need. After they
/// are read.
void check_rigid(Section& root, const SessionConfig& config);

}  // namespace haptic
