// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/tree/hash_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "contact/shape/mesh/box.h"
#include "contact/shape/mesh/distinct.h"
#include "contact/shape/tree/triangle_cube.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kOverlap = 1e-6;              // of a cell, on every side
constexpr size_t kMostRoots = 8;               // more roots are merged into their parents
constexpr size_t kPieceOfTriangles = 1 << 14;  // below, a thread does not pay off
constexpr double kMostCellsAround = 512;       // per triangle on average; a finer grid is not built
constexpr double kMostCellsCounted = 1 << 12;  // per triangle; beyond, its bounding box is used

using Index = std::array<int32_t, 3>;

/// A triangle that reaches into a cell; `cell` is first its key, then its index.
struct Entry {
  uint64_t cell;
  uint32_t triangle;
};

/// In cells, from the corner of the grid.
Corners in_cells(const TriangleMesh& mesh, uint32_t triangle, const HashGridData& grid) {
  Corners corners = corners_of(mesh, triangle);
  for (Vec3& p : corners) p = (p - grid.lower_O) / grid.cell;
  return corners;
}

Corners from_centre(Corners corners, const Index& index) {
  for (Vec3& v : corners) v -= Vec3{index[0] + 0.5, index[1] + 0.5, index[2] + 0.5};
  return corners;
}

struct IndexBox {
  Index lower, upper;
};

/// Range of cells around a triangle.
IndexBox cells_around(const Corners& corners) {
  const Vec3 overlap{kOverlap, kOverlap, kOverlap};
  const auto index_of = [](const Vec3& v) {
    return Index{static_cast<int32_t>(v.x), static_cast<int32_t>(v.y), static_cast<int32_t>(v.z)};
  };
  // the margin keeps everything positive, so truncation rounds down
  const Box box = box_around(corners);
  return {index_of(box.lower - overlap), index_of(box.upper + overlap)};
}

/// Calls f for each cell that the triangle reaches into.
template <class F>
void for_each_cell(const Corners& corners, F&& f) {
  const auto [lower, upper] = cells_around(corners);
  Index i;
  for (i[2] = lower[2]; i[2] <= upper[2]; ++i[2]) {
    for (i[1] = lower[1]; i[1] <= upper[1]; ++i[1]) {
      for (i[0] = lower[0]; i[0] <= upper[0]; ++i[0]) {
        if (triangle_meets_cube(from_centre(corners, i), 0.5 + kOverlap)) f(i);
      }
    }
  }
}

/// Whether the bounding boxes of the triangles span so many cells that sorting would take too long.
bool is_too_fine(const TriangleMesh& mesh, const HashGridData& grid) {
  double cells = 0;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [lower, upper] = cells_around(in_cells(mesh, t, grid));
    double around = 1;
    for (size_t i = 0; i < 3; ++i) around *= upper[i] - lower[i] + 1;
    cells += around;
  }
  return cells > kMostCellsAround * static_cast<double>(mesh.triangles.size());
}

std::vector<Entry> sort_triangles(const TriangleMesh& mesh, std::span<const uint32_t> triangles,
                                  const HashGridData& grid, const RunBoth& run_both) {
  std::vector<Entry> entries;
  if (triangles.size() > kPieceOfTriangles) {
    const size_t n = triangles.size() / 2;
    std::vector<Entry> rest;
    run_both([&] { entries = sort_triangles(mesh, triangles.first(n), grid, run_both); },
             [&] { rest = sort_triangles(mesh, triangles.subspan(n), grid, run_both); });
    entries.insert(entries.end(), rest.begin(), rest.end());
    return entries;
  }
  entries.reserve(4 * triangles.size());
  for (const uint32_t t : triangles) {
    for_each_cell(in_cells(mesh, t, grid), [&](const Index& i) {
      entries.push_back({cell_key(i), t});
    });
  }
  return entries;
}

/// Counts the triangles of each cell, and replaces the keys of the entries by cell indices, in the
/// order of their first triangle.
std::vector<GridSlot> number_cells(std::vector<Entry>& entries) {
  std::vector<GridSlot> cells;
  std::vector<uint32_t> table(std::bit_ceil(entries.size() + 1), ~0u);
  for (Entry& entry : entries) {
    size_t i = first_slot(entry.cell, table.size());
    while (table[i] != ~0u && cells[table[i]].key != entry.cell) i = (i + 1) & (table.size() - 1);
    if (table[i] == ~0u) {
      table[i] = static_cast<uint32_t>(cells.size());
      cells.push_back({entry.cell, 0, 0, 0});
    }
    entry.cell = table[i];
    cells[table[i]].count = (cells[table[i]].count + 1) & 0x7fffffff;
  }
  return cells;
}

/// Parent of each pair of siblings, at index (first − 1)/2.
std::vector<uint32_t> parents_of(const ObbTree& tree) {
  std::vector<uint32_t> parents(tree.nodes.size() / 2);
  for (uint32_t i = 0; i < tree.nodes.size(); ++i) {
    if (tree.nodes[i].count == 0) parents[(tree.nodes[i].first - 1) / 2] = i;
  }
  return parents;
}

std::vector<uint32_t> leaves_of(const ObbTree& tree) {
  std::vector<uint32_t> leaves(tree.order.size());
  for (uint32_t i = 0; i < tree.nodes.size(); ++i) {
    const ObbNode& node = tree.nodes[i];
    if (node.count == 0) continue;
    for (const uint32_t t : tree.order.subspan(node.first, node.count)) leaves[t] = i;
  }
  return leaves;
}

/// Replaces pairs of siblings by their parent while there are more than kMostRoots roots.
void join_siblings(std::vector<uint32_t>& roots, std::span<const uint32_t> parents) {
  for (bool joined = true; joined && roots.size() > kMostRoots;) {
    std::sort(roots.begin(), roots.end());
    joined = false;
    size_t n = 0;
    for (size_t i = 0; i < roots.size(); ++i) {
      const bool pair = i + 1 < roots.size() && roots[i] % 2 == 1 && roots[i + 1] == roots[i] + 1;
      roots[n++] = pair ? parents[(roots[i] - 1) / 2] : roots[i];
      joined = joined || pair;
      if (pair) ++i;
    }
    roots.resize(n);
  }
}

/// The subtrees that contain these triangles.
void add_roots(std::vector<uint32_t>& out, std::span<const uint32_t> triangles,
               std::span<const uint32_t> leaf_of, std::span<const uint32_t> parents) {
  std::vector<uint32_t> roots;
  for (const uint32_t t : triangles) roots.push_back(leaf_of[t]);
  keep_distinct(roots);
  join_siblings(roots, parents);
  out.insert(out.end(), roots.begin(), roots.end());
}

int8_t in_units(double value, double (*round)(double)) {
  return static_cast<int8_t>(round(std::clamp(value, -0.5, 0.5) * (2 * kCellUnits)));
}

/// Fills place `i` of a batch with a triangle relative to the centre of the cell.
void fill_place(TriangleBatch& batch, size_t i, uint32_t triangle, const Corners& corners) {
  batch.triangle[i] = triangle;
  const auto [lower, upper] = box_around(corners);
  const Vec3 n = 127.0 * normalized(cross(corners[1] - corners[0], corners[2] - corners[0]));
  Vec3 rounded;
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<size_t>(k);
    batch.lower[axis][i] = in_units(lower[k], std::floor);
    batch.minus_upper[axis][i] = in_units(-upper[k], std::floor);
    rounded[k] = std::round(n[k]);
    batch.normal[axis][i] = static_cast<int8_t>(rounded[k]);
    sum += std::fabs(rounded[k]);
  }
  double nearest = dot(rounded, corners[0]), furthest = nearest;
  for (const Vec3& v : {corners[1], corners[2]}) {
    nearest = std::min(nearest, dot(rounded, v));
    furthest = std::max(furthest, dot(rounded, v));
  }
  // the end points of a segment are rounded to half a unit
  const double slack = 0.51 * sum + 1;
  const auto bound = [](double value) {
    return static_cast<int16_t>(std::clamp(value, -32767.0, 32767.0));
  };
  batch.nearest[i] = bound(std::floor(2 * kCellUnits * nearest - slack));
  batch.furthest[i] = bound(std::ceil(2 * kCellUnits * furthest + slack));
}

void add_batches(HashGridData& grid, const TriangleMesh& mesh, uint64_t key,
                 std::span<const uint32_t> triangles) {
  constexpr uint64_t kMask = (uint64_t{1} << kGridBits) - 1;
  const Index index{static_cast<int32_t>(key & kMask),
                    static_cast<int32_t>(key >> kGridBits & kMask),
                    static_cast<int32_t>(key >> 2 * kGridBits)};
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (i % kBatch == 0) {
      grid.batches.push_back({});
      for (auto& places : grid.batches.back().lower) places.fill(kFreePlace);
    }
    const Corners corners = from_centre(in_cells(mesh, triangles[i], grid), index);
    fill_place(grid.batches.back(), i % kBatch, triangles[i], corners);
  }
}

void fill_cells(HashGridData& grid, std::vector<GridSlot>& cells, std::span<const Entry> entries,
                const TriangleMesh& mesh, const ObbTree& tree) {
  std::vector<uint32_t> triangles(entries.size()), next(cells.size());
  uint32_t end = 0;
  for (size_t i = 0; i < cells.size(); ++i) {
    next[i] = end;
    end += cells[i].count;
  }
  for (const Entry& entry : entries) triangles[next[entry.cell]++] = entry.triangle;
  const std::vector<uint32_t> parents = parents_of(tree), leaf_of = leaves_of(tree);
  for (size_t i = 0; i < cells.size(); ++i) {
    GridSlot& cell = cells[i];
    const auto held = std::span(triangles).subspan(next[i] - cell.count, cell.count);
    cell.is_crowded = cell.count > kCrowded;
    const size_t first = cell.is_crowded ? grid.roots.size() : grid.batches.size();
    if (cell.is_crowded) {
      add_roots(grid.roots, held, leaf_of, parents);
    } else {
      add_batches(grid, mesh, cell.key, held);
    }
    cell.first = static_cast<uint32_t>(first);
    const size_t count = (cell.is_crowded ? grid.roots.size() : grid.batches.size()) - first;
    cell.count = static_cast<uint32_t>(count) & 0x7fffffff;
  }
}

/// Hash table with at most half of its slots used, so that most look-ups need one probe.
std::vector<GridSlot> hash_cells(std::span<const GridSlot> cells) {
  std::vector<GridSlot> slots(std::bit_ceil(2 * cells.size() + 1));
  HAPTIC_ASSERT(std::has_single_bit(slots.size()) && slots.size() > cells.size());
  for (const GridSlot& cell : cells) {
    size_t i = first_slot(cell.key, slots.size());
    while (slots[i].count > 0) i = (i + 1) & (slots.size() - 1);
    slots[i] = cell;
  }
  return slots;
}

}  // namespace

HashGridData build_hash_grid(const TriangleMesh& mesh, const ObbTree& tree, double cell,
                             const RunBoth& run_both) {
  HashGridData grid;
  HAPTIC_ASSERT(tree.order.size() == mesh.triangles.size());
  if (tree.nodes.empty() || !(cell > largest_coordinate(mesh) * 0x1p-30) ||
      !(longest_of(mesh.upper - mesh.lower) / cell + 2 * kGridMargin + 2 < 1 << kGridBits)) {
    return grid;
  }
  grid.cell = cell;
  grid.cells_per_metre = 1 / cell;
  grid.lower_O = mesh.lower - kGridMargin * cell * Vec3{1, 1, 1};
  if (is_too_fine(mesh, grid)) return HashGridData{};
  // in tree order: neighbours in space follow each other
  std::vector<Entry> entries = sort_triangles(mesh, tree.order, grid, run_both);
  std::vector<GridSlot> cells = number_cells(entries);
  fill_cells(grid, cells, entries, mesh, tree);
  grid.slots = hash_cells(cells);
  return grid;
}

size_t cells_of_triangle(const TriangleMesh& mesh, uint32_t triangle, double cell) {
  HAPTIC_ASSERT(triangle < mesh.triangles.size() && cell > 0);
  HashGridData grid;
  grid.cell = cell;
  grid.lower_O = mesh.lower - kGridMargin * cell * Vec3{1, 1, 1};
  const Corners corners = in_cells(mesh, triangle, grid);
  const auto [lower, upper] = cells_around(corners);
  double around = 1;
  for (size_t i = 0; i < 3; ++i) around *= upper[i] - lower[i] + 1;
  if (around > kMostCellsCounted) return static_cast<size_t>(around);
  size_t cells = 0;
  for_each_cell(corners, [&](const Index&) { ++cells; });
  return cells;
}

double mean_edge_length(const TriangleMesh& mesh) {
  double sum = 0;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = corners_of(mesh, t);
    sum += norm(b - a) + norm(c - b) + norm(a - c);
  }
  return mesh.triangles.empty() ? 0 : sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

}  // namespace haptic
