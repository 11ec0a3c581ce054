// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <concepts>
#include <span>
#include <vector>

#include "contact/shape/baked/mesh_shape.h"
#include "contact/shape/convex/piece_tree.h"
#include "contact/shape/volume/distance_field.h"
#include "contact/shape/volume/pointshell.h"
#include "contact/shape/volume/voxmap.h"

namespace haptic {

/// What the voxel detector needs of one object.
struct VoxelObject {
  Voxmap map;
  DistanceField field;
};

/// Shapes for the 6-DoF renderers of a session; the spans must outlive the model.
struct BodyShapes {
  MeshShape tool;                    // in T; empty: a point
  std::vector<VoxelObject> volumes;  // per object of the session; empty: no maps
  Pointshell shell;                  // of the tool
  std::vector<PieceTree> pieces;     // per object of the session; empty: no convex pieces
  PieceTree tool_pieces;             // in T
};

/// All shapes that a session touches, ready for queries; views, whose owner must outlive the model.
struct ContactShapes {
  ContactShapes() = default;
  /// For a session whose tool is a point.
  template <std::convertible_to<std::span<const MeshShape>> Meshes>
  ContactShapes(const Meshes& meshes) {
    const std::span<const MeshShape> all = meshes;
    objects.assign(all.begin(), all.end());
  }

  std::vector<MeshShape> objects;  // in the order of the config
  // per object of the session, for its collisions with others; empty: none, or it needs none
  std::vector<PieceTree> collision_pieces;
  BodyShapes bodies;
};

}  // namespace haptic
