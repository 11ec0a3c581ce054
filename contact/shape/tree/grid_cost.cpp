// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/tree/grid_cost.h"

#include <algorithm>
#include <cmath>

#include "contact/shape/tree/hash_grid.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kMostGridBytes = 54;  // per triangle, of 120; the rest is for the trees
constexpr size_t kSample = 4096;       // triangles

/// Mean number of cells that a triangle reaches into, over a sample.
double mean_reach(const TriangleMesh& mesh, double cell) {
  HAPTIC_ASSERT(!mesh.triangles.empty() && cell > 0);
  const size_t stride = std::max<size_t>(1, mesh.triangles.size() / kSample);
  size_t cells = 0, n = 0;
  for (size_t t = 0; t < mesh.triangles.size(); t += stride, ++n) {
    cells += cells_of_triangle(mesh, static_cast<uint32_t>(t), cell);
  }
  return static_cast<double>(cells) / static_cast<double>(n);
}

double mean_area(const TriangleMesh& mesh) {
  HAPTIC_ASSERT(!mesh.triangles.empty());
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum +=
        0.5 * norm(cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]));
  }
  return sum / static_cast<double>(mesh.triangles.size());
}

}  // namespace

ValidInterval valid_interval(const QueryCosts& costs, double n_triangles) {
  HAPTIC_ASSERT(costs.batch > 0 && costs.triangle > 0);
  const double box = costs.batch / kBatch, ratio = box / costs.triangle;
  // fixed-point iteration; it contracts for M above a few
  double lower = 8;
  for (int i = 0; i < 60; ++i) lower = std::max(1.0, 2 * std::log2(lower) * ratio + 1 + ratio);
  return {lower, n_triangles / std::exp2(costs.lookup / (2 * box))};
}

std::vector<GridChoice> weigh_cells(const TriangleMesh& mesh, const QueryCosts& costs) {
  std::vector<GridChoice> choices;
  const double edge = mean_edge_length(mesh);
  const double area = mesh.triangles.empty() ? 0 : mean_area(mesh);
  if (!(area > 0)) return choices;
  for (const double edges :
       {1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0}) {
    const double cell = edges * edge;
    const double cells_per_triangle = 1.5 * area / (cell * cell);
    GridChoice choice{cell, mean_reach(mesh, cell) / cells_per_triangle, 0, 0};
    choice.triangles =
        std::clamp(choice.triangles, 1.0, static_cast<double>(mesh.triangles.size()));
    // half a batch is empty on average
    const double batches = choice.triangles / kBatch + 0.5;
    choice.cost =
        (1 + 1.5 * kTickLength / cell) * (costs.lookup + batches * costs.batch) + costs.triangle;
    // a third of the slots is used on average
    choice.bytes_per_triangle =
        cells_per_triangle * (3 * sizeof(GridSlot) + batches * sizeof(TriangleBatch));
    choices.push_back(choice);
  }
  return choices;
}

GridChoice choose_cell(const std::vector<GridChoice>& choices) {
  if (choices.empty()) return {};
  GridChoice best = choices.back();
  for (const GridChoice& choice : choices) {
    if (choice.bytes_per_triangle <= kMostGridBytes && choice.cost < best.cost) best = choice;
  }
  return best;
}

}  // namespace haptic
