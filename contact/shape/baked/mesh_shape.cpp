// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/baked/mesh_shape.h"

#include <utility>

namespace haptic {
namespace {

constexpr double kCellEdges = 1.75;  // cell size of the grid in mean edge lengths

}  // namespace

MeshShapeData build_shape(Soup soup) {
  MeshShapeData shape;
  shape.mesh = build_mesh(std::move(soup.vertices), std::move(soup.triangles));
  const TriangleMesh mesh = shape.mesh.view();
  shape.tree = build_obb_tree(mesh);
  shape.grid = build_hash_grid(mesh, shape.tree.view(), kCellEdges * mean_edge_length(mesh));
  shape.patches = build_patch_tree(mesh);
  return shape;
}

}  // namespace haptic
