// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/hash_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr double kOverlap = 1e-6;        // of a cell, on every side
constexpr size_t kMostRoots = 8;         // more boxes are worth a tree above them
constexpr size_t kPieceOfLeaves = 4096;  // below, a thread is not worth its start

using Index = std::array<int32_t, 3>;

/// A leaf that reaches into a cell; `cell` is first its key, then its number.
struct Entry {
  uint64_t cell;
  uint32_t leaf;
};

bool apart(double p, double q, double r, double radius) {
  return std::min({p, q, r}) > radius || std::max({p, q, r}) < -radius;
}

/// Separating axes of a triangle and a cube about the origin (Akenine-Möller 2001).
bool meets_cube(const std::array<Vec3, 3>& v, double half) {
  for (int i = 0; i < 3; ++i) {
    if (apart(v[0][i], v[1][i], v[2][i], half)) return false;
  }
  const Vec3 n = cross(v[1] - v[0], v[2] - v[0]);
  const double reach = half * (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z));
  if (std::fabs(dot(n, v[0])) > reach) return false;
  for (size_t i = 0; i < 3; ++i) {
    const Vec3 e = v[(i + 1) % 3] - v[i];
    for (const Vec3& axis : {Vec3{0, e.z, -e.y}, Vec3{-e.z, 0, e.x}, Vec3{e.y, -e.x, 0}}) {
      const double radius = half * (std::fabs(axis.x) + std::fabs(axis.y) + std::fabs(axis.z));
      if (apart(dot(axis, v[0]), dot(axis, v[1]), dot(axis, v[2]), radius)) return false;
    }
  }
  return true;
}

/// A leaf in units of cells.
struct LeafInCells {
  std::array<std::array<Vec3, 3>, kLeafTriangles> triangles;
  size_t count = 0;
  Index lower{}, upper{};
};

LeafInCells scale_leaf(const TriangleMesh& mesh, const ObbTree& tree, const ObbNode& leaf,
                       const HashGridData& grid) {
  LeafInCells out;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 lower{kInfinity, kInfinity, kInfinity}, upper = -lower;
  for (const uint32_t t : tree.order.subspan(leaf.first, leaf.count)) {
    std::array<Vec3, 3>& corners = out.triangles[out.count++];
    for (size_t i = 0; i < 3; ++i) {
      corners[i] = (mesh.vertices[mesh.triangles[t][i]] - grid.lower_O) / grid.cell;
      lower = component_min(lower, corners[i]);
      upper = component_max(upper, corners[i]);
    }
  }
  for (size_t i = 0; i < 3; ++i) {
    const int axis = static_cast<int>(i);
    out.lower[i] = static_cast<int32_t>(std::floor(lower[axis] - kOverlap));
    out.upper[i] = static_cast<int32_t>(std::floor(upper[axis] + kOverlap));
  }
  return out;
}

bool reaches_into(const LeafInCells& leaf, const Index& index) {
  const Vec3 centre{index[0] + 0.5, index[1] + 0.5, index[2] + 0.5};
  for (size_t k = 0; k < leaf.count; ++k) {
    std::array<Vec3, 3> corners = leaf.triangles[k];
    for (Vec3& v : corners) v -= centre;
    if (meets_cube(corners, 0.5 + kOverlap)) return true;
  }
  return false;
}

/// Which cells these leaves reach into.
std::vector<Entry> sort_leaves(const TriangleMesh& mesh, const ObbTree& tree,
                               std::span<const uint32_t> leaves, const HashGridData& grid,
                               const RunBoth& run_both) {
  std::vector<Entry> entries;
  if (leaves.size() > kPieceOfLeaves) {
    const size_t n = leaves.size() / 2;
    std::vector<Entry> rest;
    run_both([&] { entries = sort_leaves(mesh, tree, leaves.first(n), grid, run_both); },
             [&] { rest = sort_leaves(mesh, tree, leaves.subspan(n), grid, run_both); });
    entries.insert(entries.end(), rest.begin(), rest.end());
    return entries;
  }
  entries.reserve(4 * leaves.size());
  for (const uint32_t node : leaves) {
    const LeafInCells leaf = scale_leaf(mesh, tree, tree.nodes[node], grid);
    Index i;
    for (i[2] = leaf.lower[2]; i[2] <= leaf.upper[2]; ++i[2]) {
      for (i[1] = leaf.lower[1]; i[1] <= leaf.upper[1]; ++i[1]) {
        for (i[0] = leaf.lower[0]; i[0] <= leaf.upper[0]; ++i[0]) {
          if (reaches_into(leaf, i)) entries.push_back({cell_key(i), node});
        }
      }
    }
  }
  return entries;
}

/// Counts the leaves of each cell and replaces the keys of the entries by numbers of cells, in the
/// order of their first leaf.
std::vector<GridSlot> number_cells(std::vector<Entry>& entries) {
  std::vector<GridSlot> cells;
  std::vector<uint32_t> table(std::bit_ceil(entries.size() + 1), ~0u);
  for (Entry& entry : entries) {
    size_t i = first_slot(entry.cell, table.size());
    while (table[i] != ~0u && cells[table[i]].key != entry.cell) i = (i + 1) & (table.size() - 1);
    if (table[i] == ~0u) {
      table[i] = static_cast<uint32_t>(cells.size());
      cells.push_back({entry.cell, 0, 0});
    }
    entry.cell = table[i];
    ++cells[table[i]].count;
  }
  return cells;
}

/// Parent of each pair of siblings, by (first − 1)/2.
std::vector<uint32_t> parents_of(const ObbTree& tree) {
  std::vector<uint32_t> parents(tree.nodes.size() / 2);
  for (uint32_t i = 0; i < tree.nodes.size(); ++i) {
    if (tree.nodes[i].count == 0) parents[(tree.nodes[i].first - 1) / 2] = i;
  }
  return parents;
}

/// Replaces pairs of siblings by their parent while there are more than a few roots.
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

void fill_roots(HashGridData& grid, std::vector<GridSlot>& cells, std::span<const Entry> entries,
                const ObbTree& tree) {
  std::vector<uint32_t> leaves(entries.size()), next(cells.size());
  uint32_t end = 0;
  for (size_t i = 0; i < cells.size(); ++i) {
    next[i] = cells[i].first = end;
    end += cells[i].count;
  }
  for (const Entry& entry : entries) leaves[next[entry.cell]++] = entry.leaf;
  const std::vector<uint32_t> parents = parents_of(tree);
  std::vector<uint32_t> roots;
  grid.roots.reserve(entries.size());
  for (GridSlot& cell : cells) {
    const auto begin = leaves.begin() + static_cast<ptrdiff_t>(cell.first);
    roots.assign(begin, begin + static_cast<ptrdiff_t>(cell.count));
    join_siblings(roots, parents);
    cell.first = static_cast<uint32_t>(grid.roots.size());
    cell.count = static_cast<uint32_t>(roots.size());
    grid.roots.insert(grid.roots.end(), roots.begin(), roots.end());
  }
}

}  // namespace

HashGridData build_hash_grid(const TriangleMesh& mesh, const ObbTree& tree, double cell,
                             const RunBoth& run_both) {
  HashGridData grid;
  const Vec3 side = mesh.upper - mesh.lower;
  const double longest = std::max({side.x, side.y, side.z});
  const Vec3 reach = component_max(mesh.upper, -mesh.lower);
  const double furthest = std::max({std::fabs(reach.x), std::fabs(reach.y), std::fabs(reach.z)});
  if (tree.nodes.empty() || !(cell > furthest * 0x1p-30) ||
      !(longest / cell + 2 * kGridMargin + 2 < 1 << kGridBits)) {
    return grid;
  }
  grid.cell = cell;
  grid.lower_O = mesh.lower - kGridMargin * cell * Vec3{1, 1, 1};
  std::vector<uint32_t> leaves;
  for (uint32_t i = 0; i < tree.nodes.size(); ++i) {
    if (tree.nodes[i].count > 0) leaves.push_back(i);
  }
  const auto in_turn = [](const auto& first, const auto& second) { first(), second(); };
  std::vector<Entry> entries =
      sort_leaves(mesh, tree, leaves, grid, run_both ? run_both : RunBoth(in_turn));
  std::vector<GridSlot> cells = number_cells(entries);
  fill_roots(grid, cells, entries, tree);
  // at most three in four slots taken: a search ends after a step or two
  grid.slots.resize(std::bit_ceil(cells.size() + cells.size() / 3 + 1));
  for (const GridSlot& occupied : cells) {
    size_t i = first_slot(occupied.key, grid.slots.size());
    while (grid.slots[i].count > 0) i = (i + 1) & (grid.slots.size() - 1);
    grid.slots[i] = occupied;
  }
  return grid;
}

double mean_edge_length(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum += norm(mesh.vertices[b] - mesh.vertices[a]) + norm(mesh.vertices[c] - mesh.vertices[b]) +
           norm(mesh.vertices[a] - mesh.vertices[c]);
  }
  return mesh.triangles.empty() ? 0 : sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

}  // namespace haptic
