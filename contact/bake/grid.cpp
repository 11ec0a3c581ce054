// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/grid.h"

#include <algorithm>
#include <array>
#include <future>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kMostGridBytes = 54;  // per triangle, of 120; the rest is for the trees
constexpr size_t kSample = 4096;       // triangles
constexpr double kTickLength = 1e-3;   // of a fast hand in one tick of 1 kHz [m]
// as `hapt bench segment` measured them on one core of a server [s]: a step to a cell that is found
// in the hash table, and the test of eight boxes. They favour one cell for a few large triangles;
// of fine meshes the finest cells that memory allows, whatever another machine takes
constexpr double kLookupTime = 15e-9, kBatchTime = 17e-9;
// of the mean edge length
constexpr std::array kCellEdges{1.0, 1.25, 1.5, 1.75, 2.0,  2.25, 2.5,
                                3.0, 4.0,  6.0, 8.0,  12.0, 16.0};

double mean_area(const TriangleMesh& mesh) {
  double sum = 0;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = corners_of(mesh, t);
    sum += 0.5 * norm(cross(b - a, c - a));
  }
  return mesh.triangles.empty() ? 0 : sum / static_cast<double>(mesh.triangles.size());
}

/// Mean number of cells that a triangle reaches into, over a sample.
double mean_reach(const TriangleMesh& mesh, double cell) {
  const size_t stride = std::max<size_t>(1, mesh.triangles.size() / kSample);
  size_t cells = 0, n = 0;
  for (size_t t = 0; t < mesh.triangles.size(); t += stride, ++n) {
    cells += cells_of_triangle(mesh, static_cast<uint32_t>(t), cell);
  }
  return static_cast<double>(cells) / static_cast<double>(n);
}

}  // namespace

void run_on_two_threads(const std::function<void()>& first, const std::function<void()>& second) {
  std::future<void> other = std::async(std::launch::async, first);
  second();
  other.get();
}

std::vector<CellSize> weigh_cells(const TriangleMesh& mesh) {
  std::vector<CellSize> sizes;
  const double edge = mean_edge_length(mesh), area = mean_area(mesh);
  if (!(area > 0)) return sizes;
  for (const double edges : kCellEdges) {
    const double cell = edges * edge, cells_per_triangle = 1.5 * area / (cell * cell);
    const double triangles = std::clamp(mean_reach(mesh, cell) / cells_per_triangle, 1.0,
                                        static_cast<double>(mesh.triangles.size()));
    // half a batch is empty on average, and a third of the slots is used
    const double batches = triangles / kBatch + 0.5;
    sizes.push_back(
        {cell, (1 + 1.5 * kTickLength / cell) * (kLookupTime + batches * kBatchTime),
         cells_per_triangle * (3 * sizeof(GridSlot) + batches * sizeof(TriangleBatch))});
  }
  return sizes;
}

double choose_cell(const TriangleMesh& mesh) {
  const std::vector<CellSize> sizes = weigh_cells(mesh);
  if (sizes.empty()) return 0;
  CellSize best = sizes.back();
  for (const CellSize& size : sizes) {
    if (size.bytes <= kMostGridBytes && size.cost < best.cost) best = size;
  }
  return best.cell;
}

SearchStructures build_search_structures(const TriangleMesh& mesh) {
  SearchStructures built;
  run_on_two_threads([&] { built.patches = build_patch_tree(mesh); },
                     [&] {
                       built.tree = build_obb_tree(mesh, run_on_two_threads);
                       built.grid = build_hash_grid(mesh, built.tree.view(), choose_cell(mesh),
                                                    run_on_two_threads);
                     });
  return built;
}

}  // namespace haptic
