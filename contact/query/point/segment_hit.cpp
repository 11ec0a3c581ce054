// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/point/segment_hit.h"

#include <array>
#include <bit>

#include "contact/query/point/cell_walk.h"
#include "contact/query/point/segment_probe.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

SegmentProbe probe_of(const TriangleMesh& mesh, const Vec3& from_O, const Vec3& d_O) {
  const double reach = std::max(
      {largest_coordinate(from_O), largest_coordinate(from_O + d_O), largest_coordinate(mesh)});
  return {from_O, d_O, reach};
}

struct CellAhead {
  uint64_t key;
  double exit;
  CellProbe part;
  size_t slot;
  GridCell held;
  size_t end;  // of its candidates
};

using Candidates = std::array<uint32_t, kAhead * kCrowded>;

void prefetch(const void* p) {
  __builtin_prefetch(p);
}

struct Search {
  const MeshShape& shape;
  const SegmentView& view;
  Vec3 from_O, d_O;
  SegmentHit best;
  uint32_t known = kNoFace;  // the triangle of the witness, already tested
  size_t slot = 0;           // hint for the next cell

  void test(uint32_t triangle) { view.test(shape.mesh, triangle, best); }

  /// Tests the triangles of the cells along the segment, up to the first hit.
  void walk_cells(CellWalk& walk) {
    std::array<CellAhead, kAhead> ahead;
    for (bool more = true; more;) {
      size_t n = 0;
      do {
        ahead[n++] = {walk.key(), walk.exit(), walk.probe(best.t), 0, {}, 0};
        prefetch(&shape.grid.slots[first_slot(walk.key(), shape.grid.slots.size())]);
        more = !(best.hit && best.t < walk.exit()) && walk.advance();
      } while (more && n < kAhead);
      const std::span cells = std::span(ahead).first(n);
      find_batches(cells);
      Candidates candidates;
      find_candidates(cells, candidates);
      if (test_cells(cells, candidates)) return;
    }
  }

  void find_batches(std::span<CellAhead> cells) const {
    for (CellAhead& cell : cells) {
      cell.slot = shape.grid.slot_of(cell.key, slot);
      cell.held = shape.grid.at(cell.slot);
      HAPTIC_ASSERT(cell.held.batches.size() * kBatch <= kCrowded);
      for (const TriangleBatch& batch : cell.held.batches) {
        const char* bytes = reinterpret_cast<const char*>(&batch);
        for (const size_t at : {size_t{0}, size_t{64}, sizeof batch - 1}) prefetch(bytes + at);
      }
    }
  }

  /// The triangles that pass the box tests.
  void find_candidates(std::span<CellAhead> cells, Candidates& candidates) const {
    size_t n = 0;
    for (CellAhead& cell : cells) {
      for (const TriangleBatch& batch : cell.held.batches) {
        for (unsigned left = cell.part.may_meet(batch); left != 0; left &= left - 1) {
          candidates[n] = batch.triangle[static_cast<size_t>(std::countr_zero(left)) / 2];
          prefetch(&shape.mesh.triangles[candidates[n++]]);
        }
      }
      cell.end = n;
    }
    // of a single cell the corners are needed at once: prefetching gains nothing
    if (cells.size() == 1) return;
    for (const uint32_t t : std::span(candidates).first(n)) {
      for (const uint32_t v : shape.mesh.triangles[t]) prefetch(&shape.mesh.vertices[v]);
    }
  }

  /// In the order of the walk; true if the search ends in one of these cells.
  bool test_cells(std::span<const CellAhead> cells, const Candidates& candidates) {
    size_t i = 0;
    for (const CellAhead& cell : cells) {
      if (!cell.held.roots.empty()) descend_each(cell.held.roots);
      for (; i < cell.end; ++i) {
        if (candidates[i] != known) test(candidates[i]);
      }
      slot = cell.slot;
      if (best.hit && best.t < cell.exit) return true;
    }
    return false;
  }

  void descend(uint32_t root, SegmentProbe& probe) {
    // one sibling waits per level
    std::array<uint32_t, kMaxTreeDepth + 1> stack;
    size_t waiting = 0;
    stack[waiting++] = root;
    while (waiting > 0) {
      const ObbNode& node = shape.tree.nodes[stack[--waiting]];
      if (!probe.meets(node.box)) continue;
      if (node.count > 0) {
        for (const uint32_t t : shape.tree.order.subspan(node.first, node.count)) test(t);
        // what lies behind the best hit no longer matters
        if (best.hit) probe.cut(from_O, d_O, best.t);
        continue;
      }
      HAPTIC_ASSERT(waiting + 2 <= stack.size());
      const auto children = shape.tree.nodes.subspan(node.first, 2);
      const uint32_t near = probe.reaches_first(children[1].box, children[0].box) ? 1 : 0;
      stack[waiting++] = node.first + 1 - near;
      stack[waiting++] = node.first + near;
    }
  }

  void descend_each(std::span<const uint32_t> roots) {
    SegmentProbe probe = probe_of(shape.mesh, from_O, d_O);
    if (best.hit) probe.cut(from_O, d_O, best.t);
    for (const uint32_t root : roots) descend(root, probe);
  }
};

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
  SegmentView view;
  const Vec3 d_O = to_O - from_O;
  if (shape.tree.nodes.empty() || !view.look_along(from_O, d_O)) return {};
  Search search{shape, view, from_O, d_O, {}};
  search.slot = witness.slot;
  if (witness.triangle < shape.mesh.triangles.size()) {
    search.test(witness.triangle);
    search.known = witness.triangle;
  }
  CellWalk walk;
  if (!shape.grid.slots.empty() && walk.start(shape.grid, from_O, d_O)) {
    search.walk_cells(walk);
  } else {
    search.descend_each(std::array<uint32_t, 1>{0});
  }
  witness = {search.best.hit ? search.best.triangle : kNoFace, search.slot};
  return search.best;
}

}  // namespace haptic
