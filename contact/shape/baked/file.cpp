// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/baked/file.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace haptic {
namespace {

constexpr size_t kArrays = 20;  // the scalars and those of for_each_array

/// Scalars, as an array of one.
struct Facts {
  Vec3 lower, upper;
  uint64_t closed = 0;
  Vec3 grid_lower;
  double cell = 0;
};

/// Calls f for each array, in the order of the file.
template <class Content, class F>
void for_each_array(Content& content, F&& f) {
  auto& mesh = content.shape.mesh;
  f(mesh.vertices), f(mesh.triangles), f(mesh.face_normals), f(mesh.triangle_edges);
  f(mesh.edge_faces), f(mesh.vertex_valence), f(mesh.edge_normals), f(mesh.vertex_normals);
  f(content.shape.tree.nodes), f(content.shape.tree.order);
  f(content.shape.grid.slots), f(content.shape.grid.batches), f(content.shape.grid.roots);
  f(content.shape.patches.nodes), f(content.shape.patches.leaves);
  f(content.eye_vertices), f(content.eye_normals), f(content.eye_triangles), f(content.notes);
}

template <class Rows>
bool all_below(const Rows& rows, size_t limit) {
  return std::all_of(rows.begin(), rows.end(), [&](const auto& row) {
    return std::all_of(row.begin(), row.end(), [&](uint32_t i) { return i < limit; });
  });
}

void check_mesh(const TriangleMesh& mesh) {
  const size_t n_faces = mesh.triangles.size(), n_edges = mesh.edge_faces.size();
  require_baked(mesh.face_normals.size() == n_faces && mesh.triangle_edges.size() == n_faces &&
                    mesh.edge_normals.size() == n_edges &&
                    mesh.vertex_normals.size() == mesh.vertices.size() &&
                    mesh.vertex_valence.size() == mesh.vertices.size(),
                "arrays of different lengths");
  require_baked(
      all_below(mesh.triangles, mesh.vertices.size()) && all_below(mesh.triangle_edges, n_edges) &&
          std::all_of(
              mesh.edge_faces.begin(), mesh.edge_faces.end(),
              [&](const auto& f) { return f[0] < n_faces && (f[1] < n_faces || f[1] == kNoFace); }),
      "an index out of range");
}

void check_tree(const ObbTree& tree, size_t n_faces) {
  require_baked(tree.order.size() == n_faces && tree.nodes.empty() == (n_faces == 0),
                "a tree of another mesh");
  require_baked(
      std::all_of(tree.order.begin(), tree.order.end(), [&](uint32_t i) { return i < n_faces; }),
      "a triangle out of range in the tree");
  // children come after their parent: no cycles, and depths in one pass
  std::vector<int> depth(tree.nodes.size(), 0);
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    const ObbNode& node = tree.nodes[i];
    if (node.count > 0) {
      require_baked(node.first <= n_faces && node.count <= n_faces - node.first,
                    "a leaf out of range");
      continue;
    }
    require_baked(
        node.first > i && uint64_t{node.first} + 1 < tree.nodes.size() && depth[i] < kMaxTreeDepth,
        "a broken tree");
    for (const size_t child : {size_t{node.first}, size_t{node.first} + 1}) {
      depth[child] = std::max(depth[child], depth[i] + 1);
    }
  }
}

void check_grid(const HashGrid& grid, size_t n_faces, size_t n_nodes) {
  if (grid.slots.empty()) return;
  require_baked(std::has_single_bit(grid.slots.size()) && grid.cell > 0 &&
                    std::isfinite(grid.cell) && std::isfinite(grid.cells_per_metre) &&
                    is_finite(grid.lower_O) && n_nodes > 0,
                "a broken grid");
  size_t n_free = 0;
  for (const GridSlot& slot : grid.slots) {
    const size_t limit = slot.is_crowded ? grid.roots.size() : grid.batches.size();
    require_baked(slot.first <= limit && slot.count <= limit - slot.first &&
                      (slot.is_crowded || slot.count <= kCrowded / kBatch),
                  "a cell out of range");
    n_free += slot.count == 0;
  }
  // a look-up ends at a free slot
  require_baked(n_free > 0, "a grid without a free slot");
  require_baked(
      std::all_of(grid.roots.begin(), grid.roots.end(), [&](uint32_t i) { return i < n_nodes; }) &&
          std::all_of(grid.batches.begin(), grid.batches.end(),
                      [&](const TriangleBatch& batch) {
                        return std::all_of(batch.triangle.begin(), batch.triangle.end(),
                                           [&](uint32_t t) { return t < n_faces; });
                      }),
      "a triangle out of range in the grid");
}

void check_patches(const PatchTree& patches, const TriangleMesh& mesh) {
  require_baked(patches.nodes.empty() == mesh.triangles.empty(), "patches of another mesh");
  std::vector<int> depth(patches.nodes.size(), 0);
  for (size_t i = 0; i < patches.nodes.size(); ++i) {
    const PatchNode& node = patches.nodes[i];
    for (size_t lane = 0; lane < kPatchLanes; ++lane) {
      const uint32_t child = node.child[lane];
      if (child == kNoPatch) continue;
      if ((child & kPatchLeaf) != 0) {
        require_baked((child & ~kPatchLeaf) < patches.leaves.size(), "a patch out of range");
        continue;
      }
      // children come after their only parent: no cycles, and depths in one pass
      require_baked(child > i && child < patches.nodes.size() && depth[child] == 0 &&
                        depth[i] + 1 < kMaxPatchDepth,
                    "broken patches");
      depth[child] = depth[i] + 1;
    }
    require_baked(i == 0 || depth[i] > 0, "a patch without parent");
  }
  for (const PatchLeaf& leaf : patches.leaves) {
    for (size_t k = 0; k < kPatchLanes; ++k) {
      require_baked(leaf.triangle[k] == kNoFace || leaf.triangle[k] < mesh.triangles.size(),
                    "a triangle out of range in a patch");
    }
  }
}

void check_eye(const BakedContent& content) {
  require_baked(content.eye_normals.size() == content.eye_vertices.size() &&
                    all_below(content.eye_triangles, content.eye_vertices.size()),
                "an index out of range in the mesh for the eye");
}

}  // namespace

std::vector<std::byte> write_baked(const BakedContent& content, uint64_t key) {
  const MeshShape& shape = content.shape;
  const Facts facts{shape.mesh.lower, shape.mesh.upper, shape.mesh.closed, shape.grid.lower_O,
                    shape.grid.cell};
  std::vector<std::span<const std::byte>> arrays{std::as_bytes(std::span(&facts, 1))};
  for_each_array(content, [&](const auto& array) { arrays.push_back(std::as_bytes(array)); });
  return write_block(BakedKind::kShape, key, arrays);
}

BakedContent view_baked(std::span<const std::byte> bytes, uint64_t key, const RunBoth& run_both) {
  const BakedBlock block = view_block(bytes, BakedKind::kShape, key, kArrays);
  const auto facts = view_array<Facts>(block.arrays[0]);
  require_baked(facts.size() == 1, "an array of another type");
  BakedContent content;
  size_t i = 1;
  for_each_array(content, [&]<class T>(std::span<const T>& array) {
    array = view_array<T>(block.arrays[i++]);
  });
  TriangleMesh& mesh = content.shape.mesh;
  mesh.lower = facts[0].lower;
  mesh.upper = facts[0].upper;
  mesh.closed = facts[0].closed != 0;
  HashGrid& grid = content.shape.grid;
  grid.lower_O = facts[0].grid_lower;
  grid.cell = facts[0].cell;
  grid.cells_per_metre = 1 / grid.cell;
  const MeshShape& shape = content.shape;
  run_both(
      [&] {
        check_half(block, 0);
        check_mesh(shape.mesh);
        check_eye(content);
      },
      [&] {
        check_half(block, 1);
        check_tree(shape.tree, shape.mesh.triangles.size());
        check_grid(shape.grid, shape.mesh.triangles.size(), shape.tree.nodes.size());
        check_patches(shape.patches, shape.mesh);
      });
  return content;
}

}  // namespace haptic
