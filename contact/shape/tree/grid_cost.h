// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Measured costs of the parts of a query, all in the same unit of time.
struct QueryCosts {
  double lookup = 1;    // C_l: step to a cell and find it in the hash table
  double batch = 1;     // test of eight boxes: 8 C_obb
  double triangle = 1;  // C_tri: the exact test
};

/// Measured on one core of a server at 4bf98757 (bench/reference/query_costs) [s]. What another machine takes
/// decides nothing: on every mesh measured the finest cells that memory allows are the cheapest.
inline constexpr QueryCosts kQueryCosts{15e-9, 17e-9, 42e-9};

/// A size of cells, and what is expected of it.
struct GridChoice {
  double cell = 0;                // [m]
  double triangles = 0;           // M: mean per non-empty cell
  double cost = 0;                // of a query with a segment of kTickLength
  double bytes_per_triangle = 0;  // of the grid
};

/// The range of M in which the hybrid beats a pure grid (more triangles) and a pure tree (fewer
/// triangles per cell): 2 log₂M C_obb/C_tri + 1 + C_obb/C_tri < M < N / 2^(C_l/(2 C_obb)) (Gregory
/// et al. 2000).
struct ValidInterval {
  double lower = 0, upper = 0;
};
ValidInterval valid_interval(const QueryCosts& costs, double n_triangles);

/// typical segment: a fast hand in one tick of 1 kHz [m]
inline constexpr double kTickLength = 1e-3;

/// Evaluates cell sizes from the mean edge length (the rule of Gregory et al. 2000) upwards. The
/// cost is their C_h with M triangles in batches, with C_l and the batches paid once for each of
/// the 1 + 1.5 kTickLength/cell cells that a segment crosses. M is estimated from a sample of
/// triangles and the 1.5 A/cell² cells that a surface of area A meets. Empty for a mesh without
/// area.
std::vector<GridChoice> weigh_cells(const TriangleMesh& mesh, const QueryCosts& costs);

/// The cheapest size within the memory budget of the grid; the coarsest if there is none. Cell 0:
/// no grid.
GridChoice choose_cell(const std::vector<GridChoice>& choices);

}  // namespace haptic
