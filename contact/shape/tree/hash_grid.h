// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "contact/shape/tree/obb_tree.h"

namespace haptic {

/// Slot of the hash table. `count` 0: free.
struct GridSlot {
  uint64_t key = 0;    // of the cell, complete: collisions are detected
  uint32_t first = 0;  // into HashGrid::batches, or ::roots for a crowded cell
  uint32_t count : 31 = 0;
  uint32_t is_crowded : 1 = 0;
};

inline constexpr size_t kBatch = 8;        // triangles
inline constexpr uint32_t kCrowded = 128;  // triangles per cell; beyond, it refers to the tree
inline constexpr int kCellUnits = 120;     // quantisation: half a cell in units of its batches

inline constexpr int8_t kFreePlace = 127;  // marks a free place: larger than any box

/// Bounds of eight triangles within a cell, relative to its centre, in units of cell/(2
/// kCellUnits): a box, and a slab along the normal. Rounded outwards.
struct TriangleBatch {
  using Bytes = std::array<int8_t, kBatch>;
  std::array<Bytes, 3> lower, minus_upper;        // of the box, clipped to the cell
  std::array<Bytes, 3> normal;                    // of the slab, scaled by 127
  std::array<int16_t, kBatch> nearest, furthest;  // normal·point
  std::array<uint32_t, kBatch> triangle;

  /// The last batch of a cell has free places, beyond every segment.
  bool is_used(size_t i) const { return lower[0][i] != kFreePlace; }
};
static_assert(sizeof(TriangleBatch) == 17 * kBatch);

/// Contents of a cell: batches of its triangles or, if crowded, subtrees.
struct GridCell {
  std::span<const TriangleBatch> batches;
  std::span<const uint32_t> roots;
};

inline constexpr int kGridBits = 21;  // bits per cell index: h = x + y n + z n² with n = 2²¹

inline uint64_t cell_key(const std::array<int32_t, 3>& index) {
  return static_cast<uint64_t>(index[0]) | static_cast<uint64_t>(index[1]) << kGridBits |
         static_cast<uint64_t>(index[2]) << 2 * kGridBits;
}

/// Home slot of a key; the number of slots is a power of two.
inline size_t first_slot(uint64_t key, size_t n_slots) {
  // the upper half of the product depends on the whole key, the lower half on x alone
  const uint64_t scrambled = key * 0x9e3779b97f4a7c15;
  return static_cast<size_t>(scrambled ^ scrambled >> 32) & (n_slots - 1);
}

/// Uniform grid in a hash table (H-Collide; Gregory, Lin, Gottschalk, Taylor 2000). The tree of a
/// cell is flat: boxes and slabs of its triangles, eight per batch. A crowded cell has the roots of
/// those subtrees of the mesh's OBB tree that contain its triangles. Only a view is searched.
template <template <class> class Array>
struct HashGridOf {
  Vec3 lower_O;     // corner of the cell (0, 0, 0)
  double cell = 0;  // edge of a cell [m]
  double cells_per_metre = 0;
  Array<GridSlot> slots;  // power of two, linear probing; empty: no grid
  Array<TriangleBatch> batches;
  Array<uint32_t> roots;  // nodes of the OBB tree

  HashGridOf<ArrayView> view() const {
    return {lower_O, cell, cells_per_metre, slots, batches, roots};
  }
  /// Empty for a cell without triangles.
  GridCell find(uint64_t key) const { return at(slot_of(key)); }
  /// Slot of a cell; a free slot for one without triangles. `likely` is probed first: only a hint.
  size_t slot_of(uint64_t key, size_t likely = 0) const {
    const auto is_of = [&](size_t i) { return slots[i].key == key && slots[i].count > 0; };
    if (likely < slots.size() && is_of(likely)) return likely;
    size_t i = first_slot(key, slots.size());
    while (slots[i].count > 0 && slots[i].key != key) i = (i + 1) & (slots.size() - 1);
    return i;
  }
  GridCell at(size_t slot) const {
    const auto& [key, first, count, is_crowded] = slots[slot];
    if (count == 0) return {};
    if (is_crowded) return {{}, roots.subspan(first, count)};
    return {batches.subspan(first, count), {}};
  }
};
using HashGrid = HashGridOf<ArrayView>;
using HashGridData = HashGridOf<ArrayData>;

/// Empty cells around the bounds of the mesh, so that a probe just outside stays in the grid.
inline constexpr int kGridMargin = 16;

/// Sorts the triangles of a mesh into cells of this size; at start-up only. Cells overlap by a
/// millionth of their size, which covers every rounding of a traversal. The result does not depend
/// on run_both. Empty if the mesh is, if a cell is too small to be indexed (2²¹ per side, 2⁻³⁰ of
/// the largest coordinate), or if the boxes around the triangles span more than 512 cells on
/// average.
HashGridData build_hash_grid(const TriangleMesh& mesh, const ObbTree& tree, double cell,
                             const RunBoth& run_both = run_in_turn);

/// Number of cells of this size that a triangle reaches into.
size_t cells_of_triangle(const TriangleMesh& mesh, uint32_t triangle, double cell);

/// Mean over the sides of all triangles [m]: the cell size of Gregory et al. 2000.
double mean_edge_length(const TriangleMesh& mesh);

}  // namespace haptic
