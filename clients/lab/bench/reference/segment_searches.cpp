// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/segment_searches.h"

#include "contact/query/point/cell_walk.h"
#include "contact/query/point/segment_probe.h"

namespace haptic {
namespace {

/// The first hit of those tested.
struct Search {
  const MeshShape& shape;
  const SegmentView& view;
  SegmentHit best;

  void test(uint32_t triangle) { view.test(shape.mesh, triangle, best); }

  /// All leaves below `root` that are reached through accepted nodes.
  template <class Accept>
  void test_leaves(uint32_t root, Accept&& accept) {
    std::array<uint32_t, kMaxTreeDepth + 1> stack;
    size_t waiting = 0;
    stack[waiting++] = root;
    while (waiting > 0) {
      const ObbNode& node = shape.tree.nodes[stack[--waiting]];
      if (!accept(node)) continue;
      if (node.count > 0) {
        for (const uint32_t t : shape.tree.order.subspan(node.first, node.count)) test(t);
        continue;
      }
      stack[waiting++] = node.first + 1;
      stack[waiting++] = node.first;
    }
  }

  void test_cell(const GridCell& cell) {
    for (const TriangleBatch& batch : cell.batches) {
      for (size_t i = 0; i < kBatch; ++i) {
        if (batch.is_used(i)) test(batch.triangle[i]);
      }
    }
    for (const uint32_t root : cell.roots) {
      test_leaves(root, [](const ObbNode&) { return true; });
    }
  }
};

}  // namespace

SegmentHit first_hit_by_grid(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O) {
  SegmentView view;
  CellWalk walk;
  const Vec3 d_O = to_O - from_O;
  if (!view.look_along(from_O, d_O)) return {};
  if (shape.grid.slots.empty() || !walk.start(shape.grid, from_O, d_O)) {
    return first_hit_by_tree(shape, from_O, to_O);
  }
  Search search{shape, view, {}};
  do {
    search.test_cell(shape.grid.find(walk.key()));
  } while (!(search.best.hit && search.best.t < walk.exit()) && walk.advance());
  return search.best;
}

SegmentHit first_hit_by_tree(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O) {
  MeshShape without_grid = shape;
  without_grid.grid = {};
  return first_hit(without_grid, from_O, to_O);
}

SegmentHit first_hit_naive(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O) {
  SegmentView view;
  const Vec3 d_O = to_O - from_O, middle_O = from_O + 0.5 * d_O;
  if (shape.tree.nodes.empty() || !view.look_along(from_O, d_O)) return {};
  const double half = 0.5 * norm(d_O);
  Search search{shape, view, {}};
  search.test_leaves(0, [&](const ObbNode& node) {
    const Obb box = node.box.unpacked();
    return norm(box.centre_O - middle_O) <= (half + norm(box.half)) * kCompactSlack;
  });
  return search.best;
}

}  // namespace haptic
