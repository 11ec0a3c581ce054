// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/hash_grid.h"
#include "contact/shape/obb_tree.h"
#include "contact/shape/patch_tree.h"
#include "contact/shape/triangle_mesh.h"

namespace haptic {

/// What a query needs of one object. Without a grid every first hit takes the tree.
struct MeshShape {
  TriangleMesh mesh;
  ObbTree tree;
  HashGrid grid;
  PatchTree patches;
};

}  // namespace haptic
