// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/bench_segment.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "clients/bench_segment_peers.h"
#include "clients/bench_workload.h"
#include "clients/median.h"
#include "clients/print_rows.h"
#include "contact/bake.h"
#include "contact/bake_grid.h"
#include "contact/query/segment_hit.h"
#include "contact/shape/mesh_topology.h"
#include "proto/environment.h"
#include "proto/realtime.h"

namespace haptic {
namespace {

constexpr size_t kChunk = 1000;  // queries of one contestant before the next has its turn
constexpr const char* kLeftOut = "LEFT OUT: install with ./run bench";
constexpr double kGoalMedian = 0.5, kGoalP99 = 0.7, kGoalGrowth = 1.5, kGoalBytes = 120;

struct Options {
  int rounds = 3;
  size_t segments = 20000, checked = 200;
  bool json = false;
};

struct Contestant {
  std::string name;
  std::function<SegmentHit(size_t)> query;
  std::vector<double> all, hit, miss;  // durations [s]
  std::vector<double> chunks;          // of each chunk, the same chunks for all
  std::vector<SegmentHit> answers;
};

struct BenchMesh {
  WorkloadMesh work;
  MeshData mesh;
  ObbTreeData tree;
  HashGridData grid;
  MeshShape view() const { return {mesh.view(), tree.view(), grid.view(), {}}; }
};

/// Seconds that an empty measurement takes: subtracted from each.
double overhead() {
  int64_t best_ns = INT64_MAX;
  for (int i = 0; i < 10000; ++i) {
    const int64_t start_ns = now_ns();
    best_ns = std::min(best_ns, now_ns() - start_ns);
  }
  return 1e-9 * static_cast<double>(best_ns);
}

/// All contestants by turns, in an order that changes with each chunk.
void run_by_turns(std::vector<Contestant>& contestants, size_t n, int rounds) {
  const double empty = overhead();
  for (Contestant& c : contestants) c.answers.resize(n);
  for (int round = 0; round < rounds; ++round) {
    for (size_t begin = 0, chunk = 0; begin < n; begin += kChunk, ++chunk) {
      for (size_t k = 0; k < contestants.size(); ++k) {
        Contestant& c = contestants[(k + chunk + static_cast<size_t>(round)) % contestants.size()];
        double sum = 0;
        for (size_t i = begin; i < std::min(n, begin + kChunk); ++i) {
          const int64_t start_ns = now_ns();
          c.answers[i] = c.query(i);
          const double s = std::max(0.0, 1e-9 * static_cast<double>(now_ns() - start_ns) - empty);
          c.all.push_back(s);
          sum += s;
        }
        c.chunks.push_back(sum);
      }
    }
  }
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto k = static_cast<size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<ptrdiff_t>(k), values.end());
  return values[k];
}

double median_ratio(const Contestant& a, const Contestant& b) {
  std::vector<double> ratios;
  for (size_t i = 0; i < a.chunks.size(); ++i) ratios.push_back(a.chunks[i] / b.chunks[i]);
  return median(ratios);
}

BenchMesh prepare(WorkloadMesh work) {
  BenchMesh bench;
  bench.work = std::move(work);
  bench.mesh = build_mesh(bench.work.soup.vertices, bench.work.soup.triangles);
  return bench;
}

/// Every triangle, one after the other, in double.
SegmentHit brute_hit(const TriangleMesh& mesh, const WorkloadSegment& s) {
  SegmentHit best;
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    double t = 0;
    if (segment_enters_triangle(s.from_O, s.to_O, mesh.vertices[a], mesh.vertices[b],
                                mesh.vertices[c], t) &&
        (!best.hit || t < best.t)) {
      best = {true, t, i};
    }
  }
  return best;
}

bool same(const SegmentHit& a, const SegmentHit& b) {
  return a.hit == b.hit && (!a.hit || (a.t == b.t && a.triangle == b.triangle));
}

std::vector<Contestant> own_contestants(const MeshShape& shape,
                                        const std::vector<WorkloadSegment>& segments,
                                        SegmentWitness& witness) {
  std::vector<Contestant> contestants(5);
  contestants[0].name = "with witness";
  contestants[0].query = [&](size_t i) {
    return first_hit(shape, segments[i].from_O, segments[i].to_O, witness);
  };
  const auto add = [&](size_t k, const char* name, SegmentSearch search) {
    contestants[k].name = name;
    contestants[k].query = [&shape, &segments, search](size_t i) {
      return first_hit_by(search, shape, segments[i].from_O, segments[i].to_O);
    };
  };
  add(1, "hybrid", SegmentSearch::kHybrid);
  add(2, "grid", SegmentSearch::kGrid);
  add(3, "tree", SegmentSearch::kTree);
  add(4, "naive", SegmentSearch::kNaive);
  return contestants;
}

void check_answers(Rows& rows, const std::vector<Contestant>& own, const MeshShape& shape,
                   const std::vector<WorkloadSegment>& segments, size_t checked) {
  double missed = 0, extra = 0, different = 0;
  const size_t stride = std::max<size_t>(1, segments.size() / std::max<size_t>(1, checked));
  for (size_t i = 0; i < segments.size(); ++i) {
    for (const Contestant& c : own) different += !same(c.answers[i], own[0].answers[i]);
    if (i % stride != 0) continue;
    const SegmentHit truth = brute_hit(shape.mesh, segments[i]);
    missed += truth.hit && !own[0].answers[i].hit;
    extra += !truth.hit && own[0].answers[i].hit;
    different += !same(truth, own[0].answers[i]);
  }
  rows.add("missed, against brute force", missed, "", 0, missed == 0);
  rows.add("extra, against brute force", extra, "", 0, extra == 0);
  rows.add("different between the five searches and brute force", different, "", 0, different == 0);
}

void split_by_class(std::vector<Contestant>& contestants, size_t n) {
  for (Contestant& c : contestants) {
    // times lie chunk after chunk in the order of the queries, round after round
    for (size_t k = 0; k < c.all.size(); ++k) {
      (contestants[0].answers[k % n].hit ? c.hit : c.miss).push_back(c.all[k]);
    }
  }
}

void add_times(Rows& rows, const Contestant& c, const Contestant* peer) {
  const auto add = [&](const std::string& what, double value, double of_peer) {
    peer != nullptr ? rows.add_beside(c.name + " " + what, value, "s", peer->name, of_peer)
                    : rows.add(c.name + " " + what, value, "s");
  };
  add("p50", percentile(c.all, 0.5), peer ? percentile(peer->all, 0.5) : 0);
  add("p99", percentile(c.all, 0.99), peer ? percentile(peer->all, 0.99) : 0);
  add("p50 of hits", percentile(c.hit, 0.5), peer ? percentile(peer->hit, 0.5) : 0);
  add("p50 of misses", percentile(c.miss, 0.5), peer ? percentile(peer->miss, 0.5) : 0);
}

/// The columns of the paper's table, as ratios to the hybrid.
void add_columns(Rows& rows, const std::vector<Contestant>& own) {
  for (size_t k = 2; k < 5; ++k) {
    rows.add(own[k].name + " : hybrid, mean (median of chunks)", median_ratio(own[k], own[1]), "");
    rows.add(own[k].name + " : hybrid, worst 1 %",
             percentile(own[k].all, 0.99) / percentile(own[1].all, 0.99), "");
  }
}

struct MeshResult {
  std::vector<Row> rows;
  double p50 = 0;  // with witness
};

MeshResult bench_mesh(WorkloadMesh work, const Options& options) {
  Rows rows(work.name);
  BenchMesh bench = prepare(std::move(work));
  const int64_t start_ns = now_ns();
  bench.tree = build_obb_tree(bench.mesh.view(), run_on_two_threads);
  bench.grid = bake_grid(bench.mesh.view(), bench.tree.view()).grid;
  rows.add("tree and grid built", 1e-9 * static_cast<double>(now_ns() - start_ns), "s");
  const MeshShape shape = bench.view();
  const double bytes =
      static_cast<double>(shape.tree.nodes.size_bytes() + shape.tree.order.size_bytes() +
                          shape.grid.slots.size_bytes() + shape.grid.batches.size_bytes() +
                          shape.grid.roots.size_bytes()) /
      static_cast<double>(shape.mesh.triangles.size());
  rows.add("tree and grid, bytes a triangle", bytes, "", kGoalBytes, bytes <= kGoalBytes);
  rows.add("cell", shape.grid.cell, "m");
  const std::vector<WorkloadSegment> segments =
      dragged_segments(shape, bench.work.kind, options.segments);
  SegmentWitness witness;
  std::vector<Contestant> contestants = own_contestants(shape, segments, witness);
  std::vector<NamedPeer> peers = make_segment_peers(shape.mesh);
  for (NamedPeer& named : peers) {
    if (!named.peer) {
      rows.note(named.name, kLeftOut);
      continue;
    }
    Contestant& c = contestants.emplace_back();
    c.name = named.name;
    c.query = [&segments, peer = named.peer.get()](size_t i) {
      const double t = peer->first_hit(segments[i].from_O, segments[i].to_O);
      return SegmentHit{t >= 0, t, 0};
    };
  }
  run_by_turns(contestants, segments.size(), options.rounds);
  split_by_class(contestants, segments.size());
  const Contestant& best = contestants[0];
  rows.add("hits", static_cast<double>(best.hit.size()) / static_cast<double>(best.all.size()), "");
  check_answers(rows, {contestants.begin(), contestants.begin() + 5}, shape, segments,
                options.checked);
  for (size_t k = 5; k < contestants.size(); ++k) {
    double flips = 0;
    for (size_t i = 0; i < segments.size(); ++i) {
      flips += contestants[k].answers[i].hit != best.answers[i].hit;
    }
    add_times(rows, best, &contestants[k]);
    rows.add(contestants[k].name + ", hit or miss answered otherwise", flips, "");
    if (k > 5 || !peers[0].peer) continue;
    const double p50 = percentile(best.all, 0.5) / percentile(contestants[k].all, 0.5);
    const double p99 = percentile(best.all, 0.99) / percentile(contestants[k].all, 0.99);
    rows.add("p50, of Embree's", p50, "", kGoalMedian, p50 <= kGoalMedian);
    rows.add("p99, of Embree's", p99, "", kGoalP99, p99 <= kGoalP99);
  }
  for (size_t k = 1; k < 5; ++k) add_times(rows, contestants[k], nullptr);
  add_columns(rows, contestants);
  return {rows.rows(), percentile(best.all, 0.5)};
}

/// The armadillo of libcgal-demo, where it is.
std::vector<WorkloadMesh> scanned_meshes(Rows& rows) {
  const std::string own = environment("HAPTICD_MESHES");
  const std::string path =
      (own.empty() ? HAPTICD_SOURCE_DIR "/build/meshes" : own) + "/armadillo.off";
  ObjectConfig object{};
  assign(object.mesh, path);
  object.size = 0.1;
  object.allow_open = 1;
  try {
    const BakedShape baked = bake_object(object, uint64_t{4} << 30);
    const TriangleMesh& mesh = baked.shape.mesh;
    return {make_scanned("armadillo", {{mesh.vertices.begin(), mesh.vertices.end()},
                                       {mesh.triangles.begin(), mesh.triangles.end()}})};
  } catch (const MeshError& error) {
    rows.note("armadillo", std::string("LEFT OUT: ") + error.what());
    return {};
  }
}

std::vector<Row> bench_segment(const Options& options) {
  Rows rows("segment");
  rows.note("machine", machine_line());
  std::vector<WorkloadMesh> meshes = scanned_meshes(rows);
  const MeshResult small = bench_mesh(make_bump_sphere(16), options);
  rows.append(small.rows);
  for (const uint32_t frequency : {32u, 64u}) {
    rows.append(bench_mesh(make_bump_sphere(frequency), options).rows);
  }
  const MeshResult large = bench_mesh(make_bump_sphere(128), options);
  rows.append(large.rows);
  const double growth = large.p50 / small.p50;
  rows.add("p50, 320 k against 5 k triangles", growth, "", kGoalGrowth, growth <= kGoalGrowth);
  for (const uint32_t n : {78u, 708u}) {
    rows.append(bench_mesh(make_nano_surface(n), options).rows);
  }
  for (WorkloadMesh& mesh : meshes) rows.append(bench_mesh(std::move(mesh), options).rows);
  return rows.rows();
}

}  // namespace

void add_bench_segment(CLI::App& bench) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = bench.add_subcommand(
      "segment", "First hit of a dragged probe, beside Embree, CGAL and Bullet");
  command->add_option("--rounds", options->rounds, "times each segment is asked")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--segments", options->segments, "segments a mesh")
      ->check(CLI::Range(1000, 10000000))
      ->capture_default_str();
  command->add_option("--checked", options->checked, "segments compared with brute force, a mesh")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "rows as JSON");
  command->callback([options] { print_judged(bench_segment(*options), options->json); });
}

}  // namespace haptic
