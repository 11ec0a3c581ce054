// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/mesh_topology.h"
#include "contact/shape/mesh/primitives.h"
#include "contact/shape/tree/hash_grid.h"
#include "contact/shape/tree/obb_tree.h"
#include "contact/shape/tree/patch_tree.h"

namespace haptic {

/// Everything that queries need of one object. Without a grid, segment queries use the tree.
/// The views of an owner stay valid while it lives, even if moved.
template <template <class> class Array>
struct MeshShapeOf {
  TriangleMeshOf<Array> mesh;
  ObbTreeOf<Array> tree;
  HashGridOf<Array> grid;
  PatchTreeOf<Array> patches;

  MeshShapeOf<ArrayView> view() const {
    return {mesh.view(), tree.view(), grid.view(), patches.view()};
  }
};
using MeshShape = MeshShapeOf<ArrayView>;
using MeshShapeData = MeshShapeOf<ArrayData>;

/// A shape from a mesh that needs no repair; at start-up only. The cells of the grid are 1.75 mean
/// edges: what baking, which measures costs, usually chooses.
MeshShapeData build_shape(Soup soup);

}  // namespace haptic
