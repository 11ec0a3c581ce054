// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "contact/bake/volume.h"
#include "contact/shape/baked/contact_shapes.h"

namespace haptic {

/// Everything a session touches, baked, and what keeps it alive.
struct BakedSession {
  std::vector<BakedShape> objects;  // in the order of the config
  std::optional<BakedShape> tool;
  std::vector<BakedVolume> volumes;  // map and field of each object
  std::optional<BakedVolume> shell;  // of the tool

  /// Views; valid while this lives.
  ContactShapes shapes() const;
};

/// Told of each mesh before it is read ("bunny00.off"), of each step of a slow baking with the
/// share that is done, and of each finding, in lines for people.
struct BakeTold {
  std::function<void(const std::string& mesh)> begin = [](const std::string&) {};
  BakeProgress progress = {};
  std::function<void(const std::string& line)> finding = [](const std::string&) {};
};

/// Bakes the meshes of a session, or maps them from the cache; with a tool, for the renderer voxel
/// or where [contact.voxel] is asked for, the volumes too. Throws MeshError.
BakedSession bake_session(const SessionConfig& config, const BakeTold& told = {});

}  // namespace haptic
