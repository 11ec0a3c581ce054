// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/mesh_topology.h"
#include "contact/shape/mesh/primitives.h"
#include "contact/shape/tree/hash_grid.h"
#include "contact/shape/tree/obb_tree.h"
#include "contact/shape/tree/patch_tree.h"

namespace haptic {

/// What a query needs of one object. Without a grid every first hit takes the tree.
struct MeshShape {
  TriangleMesh mesh;
  ObbTree tree;
  HashGrid grid;
  PatchTree patches;
};

/// The same, owning its arrays: views hold while it lives, moved or not.
struct MeshShapeData {
  MeshData mesh;
  ObbTreeData tree;
  HashGridData grid;
  PatchTreeData patches;

  MeshShape view() const { return {mesh.view(), tree.view(), grid.view(), patches.view()}; }
};

/// A shape of a mesh that is right as it is; start-up only. The grid's cells are 1.75 mean edges:
/// what baking, which measures, chooses as a rule.
MeshShapeData build_shape(Soup soup);

}  // namespace haptic
