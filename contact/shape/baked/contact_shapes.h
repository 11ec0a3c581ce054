// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <concepts>
#include <span>
#include <vector>

#include "contact/shape/baked/mesh_shape.h"
#include "contact/shape/volume/distance_field.h"
#include "contact/shape/volume/pointshell.h"
#include "contact/shape/volume/voxmap.h"

namespace haptic {

/// What the detector needs of one object.
struct VoxelObject {
  Voxmap map;
  DistanceField field;
};

/// What a session's bodies are made of; the spans must outlive the model.
struct BodyShapes {
  MeshShape tool;                    // in T; empty: a point
  std::vector<VoxelObject> volumes;  // of each object of the session; empty: no maps
  Pointshell shell;                  // of the tool
};

/// What a session touches, ready for queries; views, their owner must outlive the model.
struct ContactShapes {
  ContactShapes() = default;
  /// Of a session whose tool is a point.
  template <std::convertible_to<std::span<const MeshShape>> Meshes>
  ContactShapes(const Meshes& meshes) {
    const std::span<const MeshShape> all = meshes;
    objects.assign(all.begin(), all.end());
  }

  std::vector<MeshShape> objects;  // in the order of the config
  BodyShapes bodies;
};

}  // namespace haptic
