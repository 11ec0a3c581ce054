// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/baked/file.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// A slot of the grid that holds a cell.
GridSlot& occupied(MeshShapeData& shape) {
  return *std::find_if(shape.grid.slots.begin(), shape.grid.slots.end(),
                       [](const GridSlot& slot) { return slot.count > 0; });
}

}  // namespace

TEST_CASE("baked file: every damaged index is refused even with a right checksum") {
  const MeshShapeData shape = build_shape(make_icosphere(1, 1));
  const auto refused = [](const MeshShapeData& bad) {
    const MeshData& eye = bad.mesh;
    const auto bytes =
        write_baked({bad.view(), eye.vertices, eye.vertex_normals, eye.triangles, {}}, 7);
    try {
      view_baked(bytes, 7);
      return false;
    } catch (const BakedFileError&) {
      return true;
    }
  };
  CHECK_FALSE(refused(shape));
  const std::vector<std::function<void(MeshShapeData&)>> breaks{
      [](MeshShapeData& s) { s.mesh.triangles[3][1] = 1u << 20; },
      [](MeshShapeData& s) { s.mesh.triangle_edges[3][1] = 1u << 20; },
      [](MeshShapeData& s) { s.mesh.edge_faces[3][0] = kNoFace; },
      [](MeshShapeData& s) { s.mesh.edge_faces[3][1] = 1u << 20; },
      [](MeshShapeData& s) { s.mesh.vertex_normals.pop_back(); },
      [](MeshShapeData& s) { s.tree.order[2] = 80; },
      [](MeshShapeData& s) { s.tree.order.pop_back(); },
      [](MeshShapeData& s) { s.tree.nodes[0].first = 0; },
      [](MeshShapeData& s) { s.tree.nodes[0].first = 1u << 27; },
      [](MeshShapeData& s) { s.tree.nodes.back().first = 1u << 27; },
      [](MeshShapeData& s) { s.tree.nodes.clear(); },
      [](MeshShapeData& s) { s.grid.slots.pop_back(); }, [](MeshShapeData& s) { s.grid.cell = 0; },
      [](MeshShapeData& s) { s.grid.cell = std::nan(""); },
      [](MeshShapeData& s) { s.grid.lower_O.y = std::nan(""); },
      [](MeshShapeData& s) { occupied(s).first = 1u << 30; },
      [](MeshShapeData& s) { occupied(s).count = 1u << 30; },
      [](MeshShapeData& s) { occupied(s).is_crowded = 1; },
      // a query has space for the triangles of normal cells
      [](MeshShapeData& s) {
        const TriangleBatch batch = s.grid.batches[0];
        s.grid.batches.insert(s.grid.batches.end(), kCrowded / kBatch + 1, batch);
        occupied(s).first = 0;
        occupied(s).count = kCrowded / kBatch + 1;
      },
      [](MeshShapeData& s) { s.grid.batches.back().triangle[7] = 80; },
      [](MeshShapeData& s) { s.grid.roots.push_back(1u << 20); },
      // a search for an absent cell would never end
      [](MeshShapeData& s) { std::fill(s.grid.slots.begin(), s.grid.slots.end(), occupied(s)); },
      [](MeshShapeData& s) { s.patches.nodes.clear(); },
      [](MeshShapeData& s) { s.patches.nodes[0].child[1] = 0; },
      [](MeshShapeData& s) { s.patches.nodes[0].child[1] = 1u << 20; },
      [](MeshShapeData& s) { s.patches.nodes[0].child[1] = s.patches.nodes[0].child[0]; },
      // two parents
      [](MeshShapeData& s) {
        s.patches.nodes[1].child[0] = static_cast<uint32_t>(s.patches.nodes.size() - 1);
      },
      [](MeshShapeData& s) { s.patches.nodes.back().child[0] = kPatchLeaf | 1u << 20; },
      [](MeshShapeData& s) { s.patches.leaves.pop_back(); },
      [](MeshShapeData& s) { s.patches.leaves[2].triangle[3] = 80; }};
  for (size_t i = 0; i < breaks.size(); ++i) {
    CAPTURE(i);
    MeshShapeData bad = shape;
    breaks[i](bad);
    CHECK(refused(bad));
  }
  const auto good = write_baked({shape.view(), {}, {}, {}, {}}, 7);
  CHECK_THROWS_AS(view_baked(good, 8), BakedFileError);
}
