// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "proto/config/session_config.h"
#include "proto/math/pose.h"

namespace haptic {

/// A tool pressed and moved on one object, in contact over much of its surface.
struct LodPair {
  std::string name;
  SessionConfig config{};              // both meshes are generated; the object is at the origin
  std::function<Pose(double t)> path;  // X_OT at the time t [s]
};

/// Voxels for a tight fit, whose gaps are narrower than a layer: surfaces are where they are [m].
VoxelConfig tight_voxels(double size, double spacing);

/// "bolt": screwed in its nut and pressed aside; "teeth": two molars that grind, each pressed 0.1
/// mm into the other; "joint": a ball that turns in its socket, pressed as deep.
LodPair make_lod_pair(const std::string& name);
inline const std::vector<std::string> kLodPairs{"bolt", "teeth", "joint"};

}  // namespace haptic
