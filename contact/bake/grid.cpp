// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/grid.h"

#include <future>
#include <sstream>

namespace haptic {
namespace {

std::string describe(const GridChoice& choice) {
  std::ostringstream text;
  text.precision(3);
  text << "cell " << 1e3 * choice.cell << " mm: " << choice.triangles
       << " triangles in a cell, expected " << 1e9 * choice.cost << " ns, "
       << choice.bytes_per_triangle << " bytes a triangle";
  return text.str();
}

std::vector<std::string> explain(const TriangleMesh& mesh, const std::vector<GridChoice>& choices,
                                 const GridChoice& chosen) {
  constexpr QueryCosts kCosts = kQueryCosts;
  std::ostringstream taken, interval;
  taken.precision(3);
  taken << "taken as costs: cell to cell with lookup C_l " << 1e9 * kCosts.lookup
        << " ns, thin box C_obb " << 1e9 * kCosts.batch / kBatch
        << " ns (eight at a time), triangle C_tri " << 1e9 * kCosts.triangle << " ns";
  const auto valid = valid_interval(kCosts, static_cast<double>(mesh.triangles.size()));
  interval.precision(3);
  interval << "a grid with trees is best for " << valid.lower << " < M < " << valid.upper
           << " triangles in a cell; M = " << chosen.triangles
           << (chosen.triangles > valid.lower && chosen.triangles < valid.upper ? " is inside"
                                                                                : " is outside");
  std::vector<std::string> lines{taken.str(), interval.str()};
  for (const GridChoice& choice : choices) {
    lines.push_back((choice.cell == chosen.cell ? "* " : "  ") + describe(choice));
  }
  return lines;
}

}  // namespace

void run_on_two_threads(const std::function<void()>& first, const std::function<void()>& second) {
  std::future<void> other = std::async(std::launch::async, first);
  second();
  other.get();
}

ExplainedGrid bake_grid(const TriangleMesh& mesh, const ObbTree& tree) {
  const std::vector<GridChoice> choices = weigh_cells(mesh, kQueryCosts);
  const GridChoice chosen = choose_cell(choices);
  if (chosen.cell == 0) return {{}, {"no grid: the mesh has no area"}};
  return {build_hash_grid(mesh, tree, chosen.cell, run_on_two_threads),
          explain(mesh, choices, chosen)};
}

SearchStructures build_search_structures(const TriangleMesh& mesh) {
  SearchStructures built;
  run_on_two_threads([&] { built.patches = build_patch_tree(mesh); },
                     [&] {
                       built.tree = build_obb_tree(mesh, run_on_two_threads);
                       built.grid = bake_grid(mesh, built.tree.view());
                     });
  return built;
}

}  // namespace haptic
