// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <memory>

#include "clients/lab/bench/peers/segment.h"
#include "clients/lab/bench/reference/segment_searches.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/bench/workloads/workload.h"
#include "clients/lab/support/scan.h"
#include "contact/bake/bake.h"
#include "contact/bake/grid.h"
#include "contact/query/point/segment_probe.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "proto/config/command_line.h"

namespace haptic {
namespace {

constexpr size_t kChunk = 1000;  // queries of one contestant per turn
// at most: median and p99 relative to Embree's, growth of the median, spread of the median
constexpr double kGoalMedian = 0.5, kGoalP99 = 0.7, kGoalGrowth = 1.5, kGoalSpread = 0.3;
constexpr size_t kSweptTriangles = 100'000;  // at most; a sweep builds a grid for each size

struct Options {
  int rounds = 3;
  size_t segments = 20000, checked = 200;
  // triangles: 5 k, 18 k, 79 k, 328 k and 499 k; 12 k and 1.0 M
  std::vector<std::string> meshes{"bump:16", "bump:30",  "bump:63",   "bump:128", "bump:158",
                                  "nano:78", "nano:708", "armadillo", "bunny"};
};

/// A shape with all its search structures.
struct BenchShape {
  MeshData mesh;
  SearchStructures built;
  MeshShape view() const {
    return {mesh.view(), built.tree.view(), built.grid.view(), built.patches.view()};
  }
};

/// Brute force over all triangles in double.
SegmentHit brute_hit(const TriangleMesh& mesh, const WorkloadSegment& s) {
  SegmentHit best;
  SegmentView view;
  if (!view.look_along(s.from_O, s.to_O - s.from_O)) return best;
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) view.test(mesh, i, best);
  return best;
}

bool same(const SegmentHit& a, const SegmentHit& b) {
  return a.hit == b.hit && (!a.hit || (a.t == b.t && a.triangle == b.triangle));
}

using Segments = std::vector<WorkloadSegment>;

/// Answers of one search, in the order of the segments.
using Answers = std::vector<SegmentHit>;

using Search = SegmentHit (*)(const MeshShape&, const Vec3& from_O, const Vec3& to_O);

Contestant by_search(const char* name, Search search, const MeshShape& shape,
                     const Segments& segments, Answers& answers) {
  answers.resize(segments.size());
  return {name, [&shape, &segments, &answers, search](size_t i) {
            answers[i] = search(shape, segments[i].from_O, segments[i].to_O);
          }};
}

double count_different(const Answers& a, const Answers& b) {
  double different = 0;
  for (size_t i = 0; i < a.size(); ++i) different += !same(a[i], b[i]);
  return different;
}

void check_answers(Rows& rows, const Answers& answers, const MeshShape& shape,
                   const Segments& segments, size_t checked) {
  double missed = 0, extra = 0, different = 0;
  const size_t stride = std::max<size_t>(1, segments.size() / std::max<size_t>(1, checked));
  for (size_t i = 0; i < segments.size(); i += stride) {
    const SegmentHit truth = brute_hit(shape.mesh, segments[i]);
    missed += truth.hit && !answers[i].hit;
    extra += !truth.hit && answers[i].hit;
    different += !same(truth, answers[i]);
  }
  rows.add({{"missed, against brute force", missed, "", kMustBeZero},
            {"extra, against brute force", extra, "", kMustBeZero},
            {"another hit than brute force", different, "", kMustBeZero}});
}

/// The times of hits only, or of misses only.
std::vector<double> times_of(const Contestant& c, const Answers& answers, bool hit) {
  std::vector<double> times;
  // times are in the order of the queries, round after round
  for (size_t k = 0; k < c.times.size(); ++k) {
    if (answers[k % answers.size()].hit == hit) times.push_back(c.times[k]);
  }
  return times;
}

void add_beside(Rows& rows, const Contestant& c, const Contestant& peer, const Answers& answers) {
  add_beside(rows, c.name, c.times, peer.name, peer.times);
  for (const bool hit : {true, false}) {
    const std::vector<double> own = times_of(c, answers, hit), other = times_of(peer, answers, hit);
    if (own.empty()) continue;
    rows.add_beside(c.name + (hit ? " p50 of hits" : " p50 of misses"), percentile(own, 50), "s",
                    peer.name, percentile(other, 50));
  }
}

/// Times our search with warm start beside the other libraries on their own data. Returns our
/// median.
double bench_beside_peers(Rows& rows, const MeshShape& shape, const Segments& segments,
                          const Options& options, Answers& answers) {
  SegmentWitness witness;
  answers.resize(segments.size());
  std::vector<Contestant> contestants{{"with witness", [&](size_t i) {
                                         answers[i] = first_hit(shape, segments[i].from_O,
                                                                segments[i].to_O, witness);
                                       }}};
  std::vector<SegmentPeer> peers = make_segment_peers(shape.mesh);
  std::erase_if(peers, [&](const SegmentPeer& peer) {
    if (!peer.first_hit) rows.note(peer.name, kLeftOut);
    return !peer.first_hit;
  });
  std::vector<std::vector<char>> peer_hits(peers.size(), std::vector<char>(segments.size()));
  for (size_t k = 0; k < peers.size(); ++k) {
    contestants.push_back({peers[k].name, [&, k](size_t i) {
                             const auto& [from_O, to_O] = segments[i];
                             peer_hits[k][i] = peers[k].first_hit(from_O, to_O) >= 0;
                           }});
  }
  take_turns(contestants, segments.size(), kChunk, options.rounds);
  const Contestant& own = contestants[0];
  const double p50 = percentile(own.times, 50), p99 = percentile(own.times, 99);
  for (size_t k = 0; k < peers.size(); ++k) {
    const Contestant& peer = contestants[k + 1];
    add_beside(rows, own, peer, answers);
    double flips = 0;
    for (size_t i = 0; i < segments.size(); ++i) flips += peer_hits[k][i] != answers[i].hit;
    rows.add(peer.name + ", hit or miss answered otherwise", flips);
    if (!peer.name.starts_with("Embree")) continue;
    const double median = p50 / percentile(peer.times, 50), tail = p99 / percentile(peer.times, 99);
    rows.add({{"p50, of Embree's", median, "", at_most(kGoalMedian)},
              {"p99, of Embree's", tail, "", at_most(kGoalP99)}});
  }
  return p50;
}

/// The times of the selected queries, the fastest round of each.
std::vector<double> fastest_of(const Contestant& c, const std::function<bool(size_t)>& counts,
                               size_t n) {
  const std::vector<double> best = fastest(c, n);
  std::vector<double> selected;
  for (size_t i = 0; i < n; ++i) {
    if (counts(i)) selected.push_back(best[i]);
  }
  return selected;
}

/// Hybrid, grid, tree and naive search, as ratios to the hybrid (Gregory et al. 2000).
void bench_columns(Rows& rows, const MeshShape& shape, const Segments& segments,
                   const Options& options, const Answers& truth) {
  std::array<Answers, 4> answers;
  std::vector<Contestant> columns{by_search("hybrid", first_hit, shape, segments, answers[0]),
                                  by_search("grid", first_hit_by_grid, shape, segments, answers[1]),
                                  by_search("tree", first_hit_by_tree, shape, segments, answers[2]),
                                  by_search("naive", first_hit_naive, shape, segments, answers[3])};
  take_turns(columns, segments.size(), kChunk, options.rounds);
  double different = 0;
  for (const Answers& other : answers) different += count_different(truth, other);
  rows.add("different between the five searches", different, "", kMustBeZero);
  for (const Contestant& c : columns) rows.add(c.name + " p50", percentile(c.times, 50), "s");
  const auto compare = [&](const std::string& which, const std::function<bool(size_t)>& counts) {
    const std::vector<double> hybrid = fastest_of(columns[0], counts, segments.size());
    for (size_t k = 1; k < columns.size(); ++k) {
      const std::vector<double> other = fastest_of(columns[k], counts, segments.size());
      const std::string ratio = columns[k].name + " : hybrid, " + which;
      rows.add({{ratio + ", mean", mean_of(other) / mean_of(hybrid)},
                {ratio + ", worst", percentile(other, 100) / percentile(hybrid, 100)}});
    }
  };
  compare("hits", [&](size_t i) { return truth[i].hit; });
  compare("misses", [&](size_t i) { return !truth[i].hit; });
  compare("all", [](size_t) { return true; });
}

/// Repeats the queries on grids of every cell size, to check how near the chosen one is to the
/// cheapest.
void bench_sweep(Rows& rows, const BenchShape& bench, const Segments& segments,
                 const Options& options) {
  const TriangleMesh mesh = bench.mesh.view();
  const std::vector<CellSize> sizes = weigh_cells(mesh);
  std::vector<HashGridData> grids;
  for (const CellSize& size : sizes) {
    grids.push_back(build_hash_grid(mesh, bench.built.tree.view(), size.cell));
  }
  std::vector<MeshShape> shapes(grids.size(), bench.view());
  std::vector<Contestant> contestants;
  std::vector<Answers> answers(grids.size());
  for (size_t k = 0; k < grids.size(); ++k) {
    shapes[k].grid = grids[k].view();
    contestants.push_back(by_search("", first_hit, shapes[k], segments, answers[k]));
  }
  take_turns(contestants, segments.size(), kChunk, options.rounds);
  std::vector<double> means;
  for (const Contestant& c : contestants) means.push_back(mean_of(fastest(c, segments.size())));
  const double least = *std::min_element(means.begin(), means.end());
  for (size_t k = 0; k < means.size(); ++k) {
    const std::string cell = readable(sizes[k].cell, "m");
    rows.add({{"sweep, cell " + cell + ", mean", means[k], "s"},
              {"sweep, cell " + cell + ", expected", sizes[k].cost, "s"}});
    if (means[k] == least) rows.add("sweep, cheapest cell", sizes[k].cell, "m");
    if (sizes[k].cell != bench.built.grid.cell) continue;
    rows.add("sweep, chosen : cheapest", means[k] / least);
  }
  rows.add({{"sweep, finest : cheapest", means.front() / least},
            {"sweep, coarsest : cheapest", means.back() / least}});
}

/// Rows of one mesh; returns the median with warm start.
double bench_mesh(Rows rows, const WorkloadMesh& work, const Options& options) {
  BenchShape bench{build_mesh(work.soup.vertices, work.soup.triangles), {}};
  bench.built = build_search_structures(bench.mesh.view());
  const MeshShape shape = bench.view();
  rows.add({{"triangles", shape.mesh.triangles.size()}, {"cell", shape.grid.cell, "m"}});
  const Segments segments = dragged_segments(shape, work.kind, options.segments);
  Answers answers;
  const double p50 = bench_beside_peers(rows, shape, segments, options, answers);
  const auto hits = std::count_if(answers.begin(), answers.end(), [](auto& a) { return a.hit; });
  rows.add("hits", static_cast<double>(hits) / static_cast<double>(answers.size()));
  check_answers(rows, answers, shape, segments, options.checked);
  bench_columns(rows, shape, segments, options, answers);
  if (shape.mesh.triangles.size() <= kSweptTriangles) bench_sweep(rows, bench, segments, options);
  return p50;
}

/// A mesh by its name on the command line. Throws MeshError.
WorkloadMesh make_mesh(const std::string& name) {
  if (name == "armadillo") return read_scanned(name, meshes_folder() + "/armadillo.off");
  if (name == "bunny") return read_scanned(name, meshes_folder() + "/bunny00.off");
  const auto n = static_cast<uint32_t>(std::stoul(name.substr(name.find(':') + 1)));
  return name.starts_with("bump:") ? make_bump_sphere(n) : make_nano_surface(n);
}

std::string problem_of_name(const std::string& name) {
  const size_t digits = name.size() - std::min(name.size(), size_t{5});
  const bool counted = (name.starts_with("bump:") || name.starts_with("nano:")) && digits >= 1 &&
                       digits <= 4 && name.find_first_not_of("0123456789", 5) == name.npos &&
                       name[5] != '0';
  return counted || name == "armadillo" || name == "bunny"
             ? ""
             : "give bump:F, nano:N, armadillo or bunny";
}

void all_rows(const Options& options, const Rows& all) {
  Rows rows = all.machine("segment");
  std::map<std::string, double> medians;
  for (const std::string& name : options.meshes) {
    try {
      const WorkloadMesh work = make_mesh(name);
      medians[name] = bench_mesh(all.of(work.name), work, options);
    } catch (const MeshError& error) {
      rows.note(name, std::string("LEFT OUT: ") + error.what());
    }
  }
  if (medians.contains("bump:16") && medians.contains("bump:128")) {
    const double growth = medians["bump:128"] / medians["bump:16"];
    rows.add("p50, 328 k against 5 k triangles", growth, "", at_most(kGoalGrowth));
  }
  if (medians.contains("bump:16") && medians.contains("bump:158")) {
    double least = medians["bump:16"], most = least;
    for (const auto& [name, p50] : medians) {
      if (!name.starts_with("bump:")) continue;
      least = std::min(least, p50);
      most = std::max(most, p50);
    }
    rows.add("p50, 5 k to 500 k triangles, to either side of the middle",
             (most - least) / (most + least), "", at_most(kGoalSpread));
  }
}

}  // namespace

/// First hit of a dragged probe (workload W1), in alternation with other libraries, and the ratios
/// hybrid : grid : tree : naive.
Measured bench_segment(Command& command) {
  const auto options = std::make_shared<Options>();
  command
      .option("--mesh", options->meshes,
              "bump:F (20 F² triangles), nano:N (2 N²), armadillo, bunny; as often as wanted")
      .check(problem_of_name);
  add_counts(command, {{"--segments", &options->segments, "segments a mesh", 100, 10000000},
                       {"--checked", &options->checked,
                        "segments compared with brute force, a mesh", 1, 1000000},
                       rounds_of(options->rounds, "times each segment is asked")});
  return measured(all_rows, options);
}

}  // namespace haptic
