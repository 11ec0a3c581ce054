// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// What the parts of a query cost on a machine, all in one unit of time.
struct QueryCosts {
  double lookup = 1;    // C_l: from cell to cell, and finding one in the hash table
  double batch = 1;     // of eight thin boxes: 8 C_obb
  double triangle = 1;  // C_tri: the exact test
};

/// As `hapt bench segment` measures them on one core of a server [s]. What another machine takes
/// decides nothing: on every mesh measured the finest cells that memory allows are the cheapest.
inline constexpr QueryCosts kQueryCosts{15e-9, 17e-9, 42e-9};

/// A size of cells, and what is expected of it.
struct GridChoice {
  double cell = 0;                // [m]
  double triangles = 0;           // M: in a cell that is not empty
  double cost = 0;                // of a segment of kTickLength
  double bytes_per_triangle = 0;  // of the grid
};

/// Where the hybrid beats a grid alone (more triangles) and a tree alone (fewer triangles per
/// cell): 2 log₂M C_obb/C_tri + 1 + C_obb/C_tri < M < N / 2^(C_l/(2 C_obb)) (Gregory et al. 2000).
struct ValidInterval {
  double lower = 0, upper = 0;
};
ValidInterval valid_interval(const QueryCosts& costs, double n_triangles);

/// A segment in use: what a quick hand moves in a tick of 1 kHz [m].
inline constexpr double kTickLength = 1e-3;

/// The sizes that were considered, from the mean edge length (the paper's rule) upwards. The cost
/// is the paper's C_h with M triangles in batches, C_l and the batches once for each of the 1 + 1.5
/// kTickLength/cell cells that a segment crosses. M comes from a sample of triangles and from
/// the 1.5 A/cell² cells that a surface of area A meets. Empty for a mesh without area.
std::vector<GridChoice> weigh_cells(const TriangleMesh& mesh, const QueryCosts& costs);

/// The cheapest of those that need no more memory than the grid may have beside the trees; the
/// coarsest where none does. Cell 0: no grid.
GridChoice choose_cell(const std::vector<GridChoice>& choices);

}  // namespace haptic
