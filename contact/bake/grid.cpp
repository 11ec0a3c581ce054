// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <future>
#include <sstream>

#include "contact/query/point/segment_hit.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int kRounds = 7;
constexpr size_t kRepeats = 2000;
constexpr size_t kStride = 7919;  // a prime: from one end of the mesh to the other

// a mesh that is smaller does not wait for a measurement: a contact process that was killed is to
// be back at once, and its cells make little difference
constexpr size_t kSmall = 5000;  // triangles
constexpr QueryCosts kTypicalCosts{15e-9, 17e-9, 42e-9};

bool is_small(const TriangleMesh& mesh) {
  return mesh.triangles.size() < kSmall;
}

/// Shortest time of one call, over a few rounds: what else the machine does only adds.
template <class F>
double time_of(F&& f) {
  int64_t best_ns = INT64_MAX;
  for (int round = 0; round < kRounds; ++round) {
    const int64_t start_ns = now_ns();
    for (size_t i = 0; i < kRepeats; ++i) f(i * kStride);
    best_ns = std::min(best_ns, now_ns() - start_ns);
  }
  return 1e-9 * static_cast<double>(best_ns) / kRepeats;
}

QueryCosts measure_costs() {
  // too large for the first cache, and asked here and there: as in use
  const Soup sphere = make_icosphere(0.05, 5);
  const MeshData data = build_mesh(sphere.vertices, sphere.triangles);
  const TriangleMesh mesh = data.view();
  const ObbTreeData tree = build_obb_tree(mesh);
  const HashGridData grid = build_hash_grid(mesh, tree.view(), 1.5 * mean_edge_length(mesh));
  const SegmentCostProbe probe({mesh, tree.view(), grid.view(), {}});
  volatile uint64_t sink = 0;
  QueryCosts costs;
  costs.lookup = time_of([&](size_t i) { sink = sink + probe.look_up(i); });
  costs.batch = time_of([&](size_t i) { sink = sink + probe.test_batch(i); });
  costs.triangle = time_of([&](size_t i) { sink = sink + probe.test_triangle(i); });
  return costs;
}

/// How long one waits for a vertex here and there [s]: nothing on a small mesh, which stays near
/// the processor, and on a large one what memory takes.
double measure_wait(const TriangleMesh& mesh) {
  if (is_small(mesh)) return 0;
  volatile size_t at = 0;
  // each place depends on what was found at the one before, and no round returns to it
  return time_of([&](size_t) {
    const auto found = std::bit_cast<uint64_t>(mesh.vertices[at].x);
    at = (at + kStride + (found & 1)) % mesh.vertices.size();
  });
}

std::string describe(const GridChoice& choice) {
  std::ostringstream text;
  text.precision(3);
  text << "cell " << 1e3 * choice.cell << " mm: " << choice.triangles
       << " triangles in a cell, expected " << 1e9 * choice.cost << " ns, "
       << choice.bytes_per_triangle << " bytes a triangle";
  return text.str();
}

std::vector<std::string> explain(const TriangleMesh& mesh, const QueryCosts& costs, double wait,
                                 const std::vector<GridChoice>& choices, const GridChoice& chosen) {
  std::ostringstream measured, interval;
  measured.precision(3);
  measured << (is_small(mesh) ? "not measured, the mesh is small: " : "measured here: ")
           << "cell to cell with lookup C_l " << 1e9 * costs.lookup << " ns, thin box C_obb "
           << 1e9 * costs.batch / kBatch << " ns (eight at a time), triangle C_tri "
           << 1e9 * costs.triangle << " ns; wait for memory " << 1e9 * wait
           << " ns, once a triangle and once " << kAhead << " cells";
  const auto valid = valid_interval(costs, static_cast<double>(mesh.triangles.size()));
  interval.precision(3);
  interval << "a grid with trees is best for " << valid.lower << " < M < " << valid.upper
           << " triangles in a cell; M = " << chosen.triangles
           << (chosen.triangles > valid.lower && chosen.triangles < valid.upper ? " is inside"
                                                                                : " is outside");
  std::vector<std::string> lines{measured.str(), interval.str()};
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

const QueryCosts& measured_costs() {
  static const QueryCosts costs = measure_costs();
  return costs;
}

ExplainedGrid bake_grid(const TriangleMesh& mesh, const ObbTree& tree) {
  const QueryCosts& costs = is_small(mesh) ? kTypicalCosts : measured_costs();
  const double wait = measure_wait(mesh);
  const std::vector<GridChoice> choices =
      weigh_cells(mesh, {costs.lookup + wait / kAhead, costs.batch, costs.triangle + wait});
  const GridChoice chosen = choose_cell(choices);
  if (chosen.cell == 0) return {{}, {"no grid: the mesh has no area"}};
  return {build_hash_grid(mesh, tree, chosen.cell, run_on_two_threads),
          explain(mesh, costs, wait, choices, chosen)};
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
