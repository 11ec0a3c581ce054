// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/segment_hit.h"

#include <array>
#include <bit>

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

  void visit_leaf(const ObbNode& leaf) {
    unsigned left = probe.may_enter(shape.tree.blocks[leaf.first / kLeafTriangles]) &
                    ((1u << leaf.count) - 1);
    for (; left != 0; left &= left - 1) {
      test(shape.tree.order[leaf.first + static_cast<uint32_t>(std::countr_zero(left))]);
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
        visit_leaf(node);
        continue;
      }
      const auto children = shape.tree.nodes.subspan(node.first, 2);
      const uint32_t near = probe.reaches_first(children[1].box, children[0].box) ? 1 : 0;
      stack[waiting++] = node.first + 1 - near;
      stack[waiting++] = node.first + near;
    }
  }
};

/// Walk from cell to cell along a segment (3-D DDA; Amanatides & Woo 1987).
class CellWalk {
 public:
  /// False where the segment leaves the indices of the grid or would cross too many cells.
  bool start(const HashGrid& grid, const Vec3& from_O, const Vec3& d_O) {
    const double per_cell = 1 / grid.cell;
    const Vec3 p = per_cell * (from_O - grid.lower_O), d = per_cell * d_O, q = p + d;
    int crossings = 0;
    for (int i = 0; i < 3; ++i) {
      if (!(p[i] >= 0 && q[i] >= 0 && p[i] < kIndices && q[i] < kIndices)) return false;
      const auto axis = static_cast<size_t>(i);
      index_[axis] = static_cast<int32_t>(p[i]);
      const int32_t cells = static_cast<int32_t>(q[i]) - index_[axis];
      crossings += cells < 0 ? -cells : cells;
      left_[axis] = cells < 0 ? -cells : cells;
      if (cells == 0) continue;
      step_[axis] = cells < 0 ? -1 : 1;
      const double border = index_[axis] + (cells > 0 ? 1 : 0);
      per_step_[axis] = std::fabs(1 / d[i]);
      exit_[axis] = (border - p[i]) / d[i];
    }
    return crossings <= kMostCrossings;
  }

  uint64_t key() const { return cell_key(index_); }

  /// Where along the segment this cell ends; beyond 1 in the last one.
  double exit() const { return std::min({exit_[0], exit_[1], exit_[2]}); }

  /// On to the next cell; false at the end.
  bool advance() {
    const size_t axis = exit_[0] <= exit_[1] && exit_[0] <= exit_[2] ? 0
                        : exit_[1] <= exit_[2]                       ? 1
                                                                     : 2;
    if (left_[axis] == 0) return false;
    index_[axis] += step_[axis];
    exit_[axis] = --left_[axis] > 0 ? exit_[axis] + per_step_[axis] : kNever;
    return true;
  }

 private:
  static constexpr double kNever = 2;
  static constexpr double kIndices = 1 << kGridBits;
  static constexpr int kMostCrossings = 64;  // a longer way is shorter through the tree

  std::array<int32_t, 3> index_{}, step_{}, left_{};
  std::array<double, 3> exit_{kNever, kNever, kNever}, per_step_{};
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
  return SegmentProbe({}, from_O, to_O - from_O, reach).meets(box);
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
                SegmentProbe(view, from_O, d_O, reach_of(shape.mesh, from_O, to_O)),
                {}};
  if (witness.triangle < shape.mesh.triangles.size()) search.test(witness.triangle);
  CellWalk walk;
  if (shape.grid.slots.empty() || !walk.start(shape.grid, from_O, d_O)) {
    search.descend(0);
  } else {
    do {
      for (const uint32_t root : shape.grid.find(walk.key())) search.descend(root);
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
                SegmentProbe(view, from_O, d_O, reach_of(shape.mesh, from_O, to_O)),
                {}};
  search.descend(0);
  return search.best;
}

}  // namespace haptic
