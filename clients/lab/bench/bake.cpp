// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>

#include "clients/hapt/scratch_folder.h"
#include "clients/lab/bench/workloads/workload.h"
#include "clients/lab/support/thread_cpu.h"
#include "contact/bake/bake.h"
#include "contact/bake/cache.h"
#include "contact/bake/grid.h"
#include "contact/shape/baked/file.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "proto/config/command_line.h"
#include "proto/os/progress.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

// at most: built and mapped [s], bytes per triangle
constexpr double kGoalBuilt = 1.5, kGoalMapped = 50e-3, kGoalBytes = 120;
constexpr uint64_t kKey = 1;  // any key: the file is written and read here only

struct Options {
  uint32_t n = 742;  // 1,101,128 triangles
  int rounds = 5;
};

/// Least wall-clock and CPU time over several rounds: other programs only add to it.
struct Times {
  double wall = 1e30, cpu = 1e30;
};
Times least_times(int rounds, const std::function<void()>& prepare,
                  const std::function<void()>& work) {
  Times least;
  Progress progress("baking", rounds);
  for (int i = 0; i < rounds; ++i) {
    progress.at(i);
    prepare();
    const int64_t start_ns = now_ns();
    const auto cpu_ns = static_cast<double>(ns_on(CLOCK_PROCESS_CPUTIME_ID, work));
    least.cpu = std::min(least.cpu, 1e-9 * cpu_ns);
    least.wall = std::min(least.wall, 1e-9 * static_cast<double>(now_ns() - start_ns));
  }
  return least;
}

void add_times(Rows& rows, const std::string& what, const Times& times, double goal) {
  rows.add(
      {{what, times.wall, "s", at_most(goal)}, {what + ", CPU of both threads", times.cpu, "s"}});
}

void bench_cache(Rows& rows, const MeshShape& shape, int rounds) {
  const ScratchFolder folder;
  const std::string path = folder.path() + "/shape.baked";
  const std::string problem = write_atomically(path, write_baked({shape, {}, {}, {}, {}}, kKey));
  if (!problem.empty()) return rows.note("mapped from the cache", "LEFT OUT: " + problem);
  MappedFile mapped;
  const auto map = [&] {
    mapped = map_file(path);
    view_baked(mapped.bytes, kKey, run_on_two_threads);
  };
  const auto unmap = [&] { mapped = {}; };
  rows.add("size in the cache", std::filesystem::file_size(path), "B");
  add_times(rows, "mapped from the cache and checked", least_times(rounds, unmap, map),
            kGoalMapped);
}

void all_rows(const Options& options, const Rows& all) {
  const WorkloadMesh work = make_nano_surface(options.n);
  Rows rows = all.machine(work.name);
  const MeshData mesh = build_mesh(work.soup.vertices, work.soup.triangles);
  const auto triangles = static_cast<double>(mesh.triangles.size());
  rows.add("triangles", triangles);
  SearchStructures built;
  const auto clear = [&] { built = {}; };
  const auto build = [&] { built = build_search_structures(mesh.view()); };
  add_times(rows, "trees and grid built", least_times(options.rounds, clear, build), kGoalBuilt);
  const MeshShape shape{mesh.view(), built.tree.view(), built.grid.view(), built.patches.view()};
  const auto bytes = [&](auto... spans) {
    return (static_cast<double>(spans.size_bytes()) + ...) / triangles;
  };
  const double tree = bytes(shape.tree.nodes, shape.tree.order);
  const double grid = bytes(shape.grid.slots, shape.grid.batches, shape.grid.roots);
  const double patches = bytes(shape.patches.nodes, shape.patches.leaves);
  rows.add({{"OBB tree, bytes a triangle", tree},
            {"grid, bytes a triangle", grid},
            {"patch tree, bytes a triangle", patches},
            {"trees and grid, bytes a triangle", tree + grid + patches, "", at_most(kGoalBytes)}});
  bench_cache(rows, shape, options.rounds);
}

}  // namespace

/// The preparation of a mesh of 1.1 M triangles for queries: trees and grid built from memory,
/// their size, and the whole shape mapped from the cache.
Measured bench_bake(Command& command) {
  const auto options = std::make_shared<Options>();
  add_counts(command, {{"--n", &options->n, "of a height field of 2 n² triangles", 2, 2000},
                       rounds_of(options->rounds, "the fastest counts")});
  return measured(all_rows, options);
}

}  // namespace haptic
