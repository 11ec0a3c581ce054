// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "contact/shape/tree/grid_cost.h"
#include "contact/shape/tree/hash_grid.h"
#include "contact/shape/tree/patch_tree.h"

namespace haptic {

/// Runs the first on a thread of its own; exceptions of both are thrown here.
void run_on_two_threads(const std::function<void()>& first, const std::function<void()>& second);

/// A grid with the cell size that kQueryCosts favour, and how that came about, a line each. The
/// same mesh has the same grid on every machine.
struct ExplainedGrid {
  HashGridData grid;
  std::vector<std::string> lines;
};
ExplainedGrid bake_grid(const TriangleMesh& mesh, const ObbTree& tree);

/// All acceleration structures of a mesh, built on two threads.
struct SearchStructures {
  ObbTreeData tree;
  ExplainedGrid grid;
  PatchTreeData patches;
};
SearchStructures build_search_structures(const TriangleMesh& mesh);

}  // namespace haptic
