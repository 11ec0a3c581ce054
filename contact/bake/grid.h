// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "contact/shape/tree/hash_grid.h"
#include "contact/shape/tree/patch_tree.h"

namespace haptic {

/// Runs the first on a thread of its own; exceptions of both are thrown here.
void run_on_two_threads(const std::function<void()>& first, const std::function<void()>& second);

/// A size of cells that a grid may have, and what is expected of it.
struct CellSize {
  double cell = 0;   // [m]
  double cost = 0;   // of a query with the segment of a fast hand, less the exact test [s]
  double bytes = 0;  // of the grid, per triangle
};

/// Cells of 1 to 16 times the mean edge length (the rule of Gregory et al. 2000), ascending. The
/// cost is their C_h with M triangles in batches, with C_l and the batches paid once for each cell
/// that the segment crosses. M is estimated from a sample of triangles and the 1.5 A/cell² cells
/// that a surface of area A meets. Empty for a mesh without area.
std::vector<CellSize> weigh_cells(const TriangleMesh& mesh);

/// The cheapest size within the memory that a grid may take; the coarsest if there is none [m]. 0:
/// no grid. The same mesh has the same size on every machine.
double choose_cell(const TriangleMesh& mesh);

/// All acceleration structures of a mesh, built on two threads.
struct SearchStructures {
  ObbTreeData tree;
  HashGridData grid;
  PatchTreeData patches;
};
SearchStructures build_search_structures(const TriangleMesh& mesh);

}  // namespace haptic
