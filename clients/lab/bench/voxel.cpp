// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <stdexcept>

#include "clients/lab/bench/voxel_ceiling.h"
#include "clients/lab/bench/voxel_contact.h"
#include "clients/lab/bench/workloads/lod_pairs.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/eval/scenes/workload.h"
#include "clients/lab/support/median.h"
#include "clients/lab/support/scan.h"
#include "clients/lab/support/soups.h"
#include "clients/lab/support/thread_cpu.h"
#include "contact/bake/volume.h"
#include "contact/query/volume/shell_in_field.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "proto/config/command_line.h"

namespace haptic {
namespace {

constexpr double kGoalOfCeiling = 0.6;  // of the ceiling's rate, at least
constexpr double kGoalRate = 200;       // [1/µs]; points for this map and shell in Morton order
constexpr uint32_t kJudgedSide = 256, kJudgedPoints = 100'000;  // with this goal
constexpr double kGoalTriangles = 0.1;  // relative change of the rate with the number of triangles
constexpr double kGoalCoherence = 10;   // factor by which coherence reduces the tested points
constexpr double kGoalMap = 25e6, kGoalField = 150e6;  // [B]; at 1024³

constexpr size_t kPoses = 8;                    // of the tool, in turn
constexpr size_t kPointsATurn = 200'000;        // lookups per turn, at least
constexpr uint32_t kToolFrequency = 64;         // of the tool's mesh, as bumpy as the object
constexpr double kFirstTurn = 1, kTurn = 0.03;  // of the first pose and from pose to pose [rad]

struct Options {
  std::vector<uint32_t> sides{256, 1024};                    // voxels along the object
  std::vector<uint32_t> points{10'000, 100'000, 1'000'000};  // of the shell
  uint32_t coarse = 16, fine = 235;                          // bumpy spheres of 20 f² triangles
  uint32_t memory_side = 1024;  // voxels along the bunny, for the memory of its maps; 0: skipped
  int rounds = 15;
  BenchVoxelContactOptions contact;
};

MeshData bumpy_sphere(uint32_t frequency, double scale) {
  Soup soup = scaled(make_bumpy_sphere(frequency), scale);
  return build_mesh(std::move(soup.vertices), std::move(soup.triangles));
}

VoxmapData map_of(const MeshData& mesh, uint32_t side) {
  const Vec3 extent = mesh.upper - mesh.lower;
  return build_voxmap(mesh.view(), {std::max({extent.x, extent.y, extent.z}) / side, 2});
}

/// About `n` points all over a bumpy sphere in Morton order.
PointshellData shell_of(uint32_t n, double scale) {
  const MeshData mesh = bumpy_sphere(kToolFrequency, scale);
  const double radius = 0.25 * (mesh.upper.x - mesh.lower.x + mesh.upper.y - mesh.lower.y);
  // a surface crosses on average 1.5 cubes per cube face area
  const double area = 4 * std::numbers::pi * radius * radius;
  return build_pointshell(mesh.view(), std::sqrt(1.5 * area / n));
}

/// The shell that is used where one is enough.
uint32_t middle(const std::vector<uint32_t>& points) {
  return points[points.size() / 2];
}

void add_point(const PointshellData& from, size_t i, PointshellData& to) {
  to.x.push_back(from.x[i]);
  to.y.push_back(from.y[i]);
  to.z.push_back(from.z[i]);
}

/// Shuffles the points, to show what their order is worth; drops the nodes, which an exhaustive
/// pass does not use.
PointshellData shuffled(const PointshellData& shell) {
  std::vector<size_t> order(shell.x.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  PointshellData mixed;
  for (const size_t i : order) add_point(shell, i, mixed);
  return mixed;
}

/// Poses of the tool in the object's map; the bumps interpenetrate, so that some points touch.
std::vector<ShellInVoxels> poses_in(const Voxmap& map) {
  std::vector<ShellInVoxels> poses;
  for (size_t k = 0; k < kPoses; ++k) {
    const Vec3 turn = (kFirstTurn + kTurn * static_cast<double>(k)) * normalized(Vec3{1, 2, 3});
    poses.push_back(shell_in_voxels(map, {{1e-3, -0.5e-3, 0.5e-3}, from_rotation_vector(turn)}));
  }
  return poses;
}

/// The points that are inside the map in every pose: the ceiling tests no border.
PointshellData kept_inside(const Voxmap& map, const PointshellData& shell,
                           std::span<const ShellInVoxels> poses) {
  PointshellData kept;
  for (size_t i = 0; i < shell.x.size(); ++i) {
    bool inside = true;
    for (const ShellInVoxels& at : poses) {
      for (size_t k = 0; k < 3; ++k) {
        const float* r = &at.rotation[3 * k];
        const float q = r[0] * shell.x[i] + r[1] * shell.y[i] + r[2] * shell.z[i];
        const float end = static_cast<float>(map.bricks[k] * kBrickSide);
        inside &= q + at.translation[k] > 1 && q + at.translation[k] < end - 1;
      }
    }
    if (inside) add_point(shell, i, kept);
  }
  return kept;
}

/// Prevents the compiler from removing an unused result.
void keep(size_t value) {
  asm volatile("" : : "r"(value));
}

/// Passes of a turn through `n` points.
size_t passes_of(size_t n) {
  return std::max(kPoses, kPointsATurn / n);
}

/// Points of a shell of `n` that a way passes in a microsecond of CPU time, by the median round.
double rate_of(const Contestant& way, size_t n) {
  return 1e-6 * static_cast<double>(passes_of(n) * n) / median(way.chunks);
}

/// Lets the ways through all `n` points of a shell take turns by their CPU time, and adds the
/// points a microsecond of each; a query is a pass at one of the poses.
void add_rates(Rows& rows, const std::string& prefix, std::vector<Contestant>& ways, size_t n,
               int rounds) {
  take_turns(ways, passes_of(n), passes_of(n), rounds, CLOCK_THREAD_CPUTIME_ID);
  for (const Contestant& way : ways) rows.add(prefix + way.name, rate_of(way, n), "1/µs");
}

/// One shell in one map.
struct Trial {
  std::string name;
  const VoxmapData& map;
  const PointshellData& shell;
  bool is_judged_rate;
};

void run_trial(const Trial& trial, int rounds, const Rows& all) {
  const Voxmap map = trial.map.view();
  const Pointshell shell = trial.shell.view();
  const auto n = static_cast<uint32_t>(shell.x.size());
  std::vector<VoxelHit> hits(n + 64);
  const std::vector<ShellInVoxels> poses = poses_in(map);
  const auto pass = [&](ScanPath path, size_t i) {
    return scan_voxels(map, shell, poses[i % kPoses], 0, n, path, hits, 0);
  };
  const auto scan = [&](ScanPath path) { return [&, path](size_t i) { keep(pass(path, i)); }; };
  const auto bare = [&](ScanPath path) {
    return [&, path](size_t i) { keep(gather_bare(map, shell, poses[i % kPoses], path)); };
  };
  const bool has_lanes = fastest_scan() == ScanPath::kLanes;
  std::vector<Contestant> ways{{"scalar", scan(ScanPath::kScalar)},
                               {"scalar ceiling", bare(ScanPath::kScalar)}};
  if (has_lanes) {
    ways.push_back({"lanes", scan(ScanPath::kLanes)});
    ways.push_back({"ceiling", bare(ScanPath::kLanes)});
  }
  Rows rows = all.of(trial.name);
  const std::string prefix = trial.name + ", ";
  size_t touching = 0;
  for (size_t i = 0; i < kPoses; ++i) touching += pass(fastest_scan(), i);
  rows.add({{prefix + "points", n},
            {prefix + "points not free",
             static_cast<double>(touching) / static_cast<double>(kPoses * n)}});
  add_rates(rows, prefix, ways, n, rounds);
  rows.add(prefix + "scalar over its ceiling", median_ratio(ways[1], ways[0]));
  if (!has_lanes) return rows.note(prefix + "lanes", "LEFT OUT: this processor has no AVX2");
  rows.add(prefix + "lanes over ceiling", median_ratio(ways[3], ways[2]), "",
           at_least(kGoalOfCeiling));
  if (!trial.is_judged_rate) return;
  rows.add(prefix + "points tested", rate_of(ways[2], n), "1/µs", at_least(kGoalRate));
}

void run_map(const Options& options, uint32_t side, std::span<const PointshellData> shells,
             const Rows& all) {
  const MeshData mesh = bumpy_sphere(kToolFrequency, 1);
  const VoxmapData map = map_of(mesh, side);
  const std::string name = std::to_string(side) + "³";
  Rows rows = all.of(name);
  const auto voxels = static_cast<double>(map.index.size() * kBrickSide * kBrickSide * kBrickSide);
  rows.add({{name + ", map", map.bytes(), "B"}, {name + ", dense", voxels / 4, "B"}});
  for (size_t i = 0; i < shells.size(); ++i) {
    const uint32_t n = options.points[i];
    const std::string points = name + ", " + std::to_string(n) + " points, ";
    const bool is_judged = side == kJudgedSide && n == kJudgedPoints;
    const PointshellData ordered = kept_inside(map.view(), shells[i], poses_in(map.view()));
    run_trial({points + "ordered", map, ordered, is_judged}, options.rounds, all);
    const PointshellData mixed = shuffled(ordered);
    run_trial({points + "shuffled", map, mixed, false}, options.rounds, all);
  }
}

/// Compares contact steps on one object meshed coarsely and finely.
void run_triangles(const Options& options, const Rows& all) {
  Rows rows = all.of("triangles of the object");
  const PointshellData data = shell_of(middle(options.points), 1);
  const Pointshell shell = data.view();
  const auto n = static_cast<uint32_t>(shell.x.size());
  const uint32_t side = options.sides.front();
  std::vector<VoxelHit> hits(n + 64);
  std::vector<Contestant> ways;
  std::vector<VoxmapData> maps;
  for (const uint32_t frequency : {options.coarse, options.fine}) {
    const MeshData mesh = bumpy_sphere(frequency, 1);
    maps.push_back(map_of(mesh, side));
    const Voxmap map = maps.back().view();
    ways.push_back({std::to_string(mesh.triangles.size()) + " triangles",
                    [&hits, map, shell, n, poses = poses_in(maps[0].view())](size_t i) {
                      const ShellInVoxels& at = poses[i % kPoses];
                      keep(scan_voxels(map, shell, at, 0, n, fastest_scan(), hits, 0));
                    }});
  }
  add_rates(rows, "", ways, n, options.rounds);
  const double ratio = median_ratio(ways[0], ways[1]);
  rows.add("many over few triangles", ratio, "",
           given(1 - kGoalTriangles, std::fabs(ratio - 1) <= kGoalTriangles));
}

constexpr double kBall = 0.05;                  // radius of the object [m]
constexpr double kCell = 0.5e-3, kBand = 4e-3;  // of the object's field [m]
constexpr double kSmallTool = 0.3;              // scale of the bumpy sphere
constexpr double kSpeed = 0.05, kSpin = 0.2;    // of the tool [m/s, rad/s]
constexpr int kTicks = 2000;                    // of 1 kHz
constexpr std::array kGaps{1e-3, 2e-3, 5e-3};   // at the highest bump of the tool [m]

/// A tool that passes close by and never touches.
Pose passing(double t, double radius, double gap) {
  const double angle = kSpeed * t / (kBall + radius + gap);
  return {rotate(from_rotation_vector({0, 0, angle}), {kBall + radius + gap, 0, 0}),
          from_rotation_vector(kSpin * t * normalized(Vec3{1, 2, 3}))};
}

/// Means over the ticks, without and with coherence.
struct Passage {
  std::array<double, 2> tested{}, cpu_ns{};
};

Passage pass_by(const DistanceField& field, const Pointshell& shell, double gap) {
  ShellCoherence coherence(shell), nothing_known(shell);
  std::vector<ShellVisit> visited(shell.nodes.size() + 1);
  std::vector<ShellTouch> touches(shell.x.size());
  Passage passage;
  for (int tick = 0; tick < kTicks; ++tick) {
    const Pose X_OT = passing(1e-3 * tick, shell.radius, gap);
    for (const size_t with : {0, 1}) {
      ShellCoherence& known = with == 1 ? coherence : nothing_known;
      nothing_known.forget();
      ShellAnswer answer;
      const int64_t ns = cpu_ns_of(
          [&] { answer = find_touches(field, shell, X_OT, {}, known, visited, touches); });
      passage.cpu_ns[with] += static_cast<double>(ns) / kTicks;
      passage.tested[with] += static_cast<double>(answer.tested) / kTicks;
      if (answer.n > 0) throw std::logic_error("the tool of a near miss touches");
    }
  }
  return passage;
}

void run_coherence(const Options& options, const Rows& all) {
  Rows rows = all.of("temporal coherence");
  const DistanceFieldData field =
      build_distance_field(-kBall * Vec3{1, 1, 1}, kBall * Vec3{1, 1, 1},
                           [](const Vec3& p) { return norm(p) - kBall; }, {kCell, kBand, kBand});
  const PointshellData shell = shell_of(middle(options.points), kSmallTool);
  rows.add("near miss, points of the shell", shell.x.size());
  for (const double gap : kGaps) {
    const auto [tested, cpu_ns] = pass_by(field.view(), shell.view(), gap);
    const std::string name = readable(gap, "m") + " off, ";
    rows.add({{name + "tested a tick, tree alone", tested[0]},
              {name + "tested a tick, coherent", tested[1]},
              {name + "CPU a tick, tree alone", 1e-9 * cpu_ns[0], "s"},
              {name + "CPU a tick, coherent", 1e-9 * cpu_ns[1], "s"},
              {name + "fewer points by coherence", tested[0] / tested[1], "",
               at_least(kGoalCoherence)}});
  }
}

/// Memory of the maps of a scan with the default band.
void run_memory(const Options& options, const Rows& all) {
  const std::string name = "bunny, " + std::to_string(options.memory_side) + "³";
  Rows rows = all.of(name);
  constexpr double kSize = 0.1;  // [m]
  try {
    const BakedShape bunny = bake_scan(meshes_folder() + "/bunny00.off", kSize);
    const VoxelConfig voxel =
        tight_voxels(kSize / options.memory_side, VoxelConfig{}.point_spacing);
    const BakedVolume volume = bake_obstacle(bunny, voxel);
    const Voxmap& map = volume.content.map;
    const DistanceField& field = volume.content.field;
    const auto map_bytes = static_cast<double>(map.index.size_bytes() + map.data.size_bytes());
    const auto field_bytes = static_cast<double>(
        field.index.size_bytes() + field.middle.size_bytes() + field.data.size_bytes());
    rows.add(
        {{name + ", map", map_bytes, "B", at_most(kGoalMap)},
         {name + ", distance field, band of two voxels", field_bytes, "B", at_most(kGoalField)}});
  } catch (const MeshError& error) {
    rows.note(name, std::string("LEFT OUT: ") + error.what());
  }
}

void all_rows(const Options& options, const Rows& all) {
  all.machine("voxel");
  std::vector<PointshellData> shells;
  for (const uint32_t n : options.points) shells.push_back(shell_of(n, 1));
  for (const uint32_t side : options.sides) run_map(options, side, shells, all);
  if (options.memory_side > 0) run_memory(options, all);
  run_triangles(options, all);
  run_coherence(options, all);
  bench_voxel_contact(options.contact, all);
}

}  // namespace

/// Points of a shell tested per microsecond of CPU time on one core in maps of a bumpy sphere:
/// Morton order and shuffled, scalar and SIMD; compared with a ceiling that does the same
/// arithmetic and loads only. Then for an object with many more triangles, the share of points of a
/// passing tool that temporal coherence leaves to be tested, and whole contact steps.
Measured bench_voxel(Command& command) {
  const auto options = std::make_shared<Options>();
  command.option("--side", options->sides, "voxels along the object; several may be given")
      .range(8, 4096);
  command.option("--points", options->points, "of the shell; several may be given")
      .range(100, 4'000'000);
  add_counts(command, {{"--coarse", &options->coarse, "object of 20 f² triangles", 1, 1500},
                       {"--fine", &options->fine, "the same, finer", 1, 1500},
                       {"--memory-side", &options->memory_side, "voxels along the bunny, 0: none",
                        0, 4096}});
  BenchVoxelContactOptions& contact = options->contact;
  command
      .option("--pair PAIR", contact.pairs,
              "of whole contact steps: bolt, free-bolt, peg, jaws; several may be given")
      .one_of({"bolt", "free-bolt", "peg", "jaws"});
  command.number("--coarser", contact.coarser, {1, 100}, "times that their voxels and points are")
      .show_default();
  add_counts(command, {{"--ticks", &contact.ticks, "contact steps of a pair", 100, 1'000'000},
                       rounds_of(options->rounds, "alternations; medians are reported")});
  return measured(all_rows, options);
}

}  // namespace haptic
