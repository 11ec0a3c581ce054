// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/segment_hit.h"

#include <array>
#include <bit>

#include "contact/query/cell_walk.h"
#include "contact/query/segment_probe.h"

namespace haptic {
namespace {

/// One query under way.
struct Search {
  const MeshShape& shape;
  Vec3 from_O, d_O;
  SegmentView view;
  SegmentProbe probe;
  SegmentHit best;

  void test(uint32_t triangle) {
    const auto& [a, b, c] = shape.mesh.triangles[triangle];
    const auto& vertices = shape.mesh.vertices;
    double t = 0;
    if (!view.enters(vertices[a], vertices[b], vertices[c], t)) return;
    if (best.hit && (t > best.t || (t == best.t && triangle >= best.triangle))) return;
    best = {true, t, triangle};
    // what lies behind the best hit is of no interest any more
    probe.cut(from_O, d_O, t);
  }

  void visit_batches(std::span<const TriangleBatch> batches, const CellProbe& part) {
    for (const TriangleBatch& batch : batches) {
      for (uint64_t left = part.may_meet(batch); left != 0; left &= left - 1) {
        test(batch.triangle[static_cast<size_t>(std::countr_zero(left)) / 8]);
      }
    }
  }

  /// Node `root` and everything below it.
  void descend(uint32_t root) {
    // one sibling waits per level
    std::array<uint32_t, kMaxTreeDepth + 1> stack;
    size_t waiting = 0;
    stack[waiting++] = root;
    while (waiting > 0) {
      const ObbNode& node = shape.tree.nodes[stack[--waiting]];
      if (!probe.meets(node.box)) continue;
      if (node.count > 0) {
        for (const uint32_t t : shape.tree.order.subspan(node.first, node.count)) test(t);
        continue;
      }
      const auto children = shape.tree.nodes.subspan(node.first, 2);
      const uint32_t near = probe.reaches_first(children[1].box, children[0].box) ? 1 : 0;
      stack[waiting++] = node.first + 1 - near;
      stack[waiting++] = node.first + near;
    }
  }
};

double reach_of(const TriangleMesh& mesh, const Vec3& from_O, const Vec3& to_O) {
  return std::max({largest_coordinate(from_O), largest_coordinate(to_O),
                   largest_coordinate(mesh.lower), largest_coordinate(mesh.upper)});
}

}  // namespace

bool segment_meets_box(const Vec3& from_O, const Vec3& to_O, const CompactObb& box) {
  const Obb all = box.unpacked();
  const double reach = std::max({largest_coordinate(from_O), largest_coordinate(to_O),
                                 largest_coordinate(all.centre_O) + norm(all.half)});
  return SegmentProbe(from_O, to_O - from_O, reach).meets(box);
}

bool segment_enters_triangle(const Vec3& from_O, const Vec3& to_O, const Vec3& a, const Vec3& b,
                             const Vec3& c, double& t) {
  SegmentView view;
  return view.look_along(from_O, to_O - from_O) && view.enters(a, b, c, t);
}

SegmentHit first_hit(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O) {
  SegmentWitness nothing_known;
  return first_hit(shape, from_O, to_O, nothing_known);
}

SegmentHit first_hit(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O,
                     SegmentWitness& witness) {
  const Vec3 d_O = to_O - from_O;
  SegmentView view;
  if (shape.tree.nodes.empty() || !view.look_along(from_O, d_O)) return {};
  Search search{shape, from_O, d_O, view,
                SegmentProbe(from_O, d_O, reach_of(shape.mesh, from_O, to_O)),
                {}};
  if (witness.triangle < shape.mesh.triangles.size()) search.test(witness.triangle);
  CellWalk walk;
  if (shape.grid.slots.empty() || !walk.start(shape.grid, from_O, d_O)) {
    search.descend(0);
  } else {
    do {
      const GridCell cell = shape.grid.find(walk.key());
      if (!cell.batches.empty()) search.visit_batches(cell.batches, walk.probe());
      for (const uint32_t root : cell.roots) search.descend(root);
    } while (!(search.best.hit && search.best.t < walk.exit()) && walk.advance());
  }
  if (search.best.hit) witness.triangle = search.best.triangle;
  return search.best;
}

SegmentHit first_hit_by_tree(const MeshShape& shape, const Vec3& from_O, const Vec3& to_O) {
  const Vec3 d_O = to_O - from_O;
  SegmentView view;
  if (shape.tree.nodes.empty() || !view.look_along(from_O, d_O)) return {};
  Search search{shape, from_O, d_O, view,
                SegmentProbe(from_O, d_O, reach_of(shape.mesh, from_O, to_O)),
                {}};
  search.descend(0);
  return search.best;
}

}  // namespace haptic
