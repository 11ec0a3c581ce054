// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/hash_grid.h"
#include "contact/shape/obb_tree.h"
#include "contact/shape/triangle_mesh.h"

namespace haptic {

/// What a query needs of one object. Without a grid every query takes the tree.
struct MeshShape {
  TriangleMesh mesh;
  ObbTree tree;
  HashGrid grid;
};

}  // namespace haptic
