// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "contact/bake/pieces.h"
#include "contact/bake/volume.h"
#include "contact/shape/baked/contact_shapes.h"

namespace haptic {

/// All baked shapes of a session, and their storage.
struct BakedSession {
  std::vector<BakedShape> objects;  // in the order of the config
  std::optional<BakedShape> tool;
  std::vector<BakedVolume> volumes;  // map and field of each object
  std::optional<BakedVolume> shell;  // of the tool
  std::vector<BakedPieces> pieces;   // of each object
  std::optional<BakedPieces> tool_pieces;
  std::vector<BakedPieces> collision_pieces;  // of each object; empty where it needs none

  /// Views; valid while this lives.
  ContactShapes shapes() const;
};

/// Callbacks: before each mesh is read ("bunny00.off"), for the progress of slow baking, and for
/// each finding, in lines for people.
struct BakeTold {
  std::function<void(const std::string& mesh)> begin = [](const std::string&) {};
  BakeProgress progress = {};
  std::function<void(const std::string& line)> finding = [](const std::string&) {};
};

/// Bakes the meshes of a session, or maps them from the cache; with a tool, and for the renderer
/// voxel or if [contact.voxel] is given, the volumes too, and likewise the convex pieces
/// ([contact.pieces]). Throws MeshError.
BakedSession bake_session(const SessionConfig& config, const BakeTold& told = {});

/// The convex pieces of the objects that collide with others by them, in the order of the config.
std::vector<BakedPieces> bake_collision_pieces(const SessionConfig& config,
                                               std::span<const BakedShape> objects,
                                               const BakeTold& told = {});

}  // namespace haptic
