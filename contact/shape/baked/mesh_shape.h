// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/mesh_topology.h"
#include "contact/shape/mesh/primitives.h"
#include "contact/shape/tree/hash_grid.h"
#include "contact/shape/tree/obb_tree.h"
#include "contact/shape/tree/patch_tree.h"

namespace haptic {

/// Everything that queries need of one object. Without a grid, segment queries use the tree.
struct MeshShape {
  TriangleMesh mesh;
  ObbTree tree;
  HashGrid grid;
  PatchTree patches;
};

/// A MeshShape that owns its arrays: views stay valid while it lives, even if moved.
struct MeshShapeData {
  MeshData mesh;
  ObbTreeData tree;
  HashGridData grid;
  PatchTreeData patches;

  MeshShape view() const { return {mesh.view(), tree.view(), grid.view(), patches.view()}; }
};

/// A shape from a mesh that needs no repair; at start-up only. The cells of the grid are 1.75 mean
/// edges: what baking, which measures costs, usually chooses.
MeshShapeData build_shape(Soup soup);

}  // namespace haptic
