// SPDX-License-Identifier: GPL-3.0-or-later
// hapt bench: measures this machine, in alternation with a peer library.
#include <array>
#include <memory>

#include "clients/hapt/commands.h"
#include "clients/hapt/options.h"
#include "clients/lab/bench/benches.h"
#include "clients/report/print_rows.h"

namespace haptic {
namespace {

/// The option --rounds; `most` is 0 where there is none.
struct Rounds {
  int usual = 0, most = 0;
  const char* help = "";
};

struct Bench {
  const char* name;
  const char* help;
  BenchRun (*prepare)(Command& command);
  Rounds rounds = {};
};

constexpr std::array kBenches{
    Bench{"ring",
          "Channel between processes, compared with boost::lockfree::spsc_queue",
          bench_ring,
          {5, 1000, "alternations; medians are reported"}},
    Bench{"ccd",
          "Continuous collision of features and meshes, compared with FCL and Redon's intervals",
          bench_ccd,
          {5, 1000, "alternations"}},
    Bench{"closest",
          "Closest point of a mesh, compared with Embree's point query and CGAL's AABB tree",
          bench_closest,
          {3, 1000, "passes over all points"}},
    Bench{"point-proxy", "A whole contact step, dragged over meshes of 5 k to 1.1 M triangles",
          bench_point_proxy},
    Bench{"voxel",
          "Throughput of point-shell lookups against raw memory speed; contact steps against FCL",
          bench_voxel,
          {15, 1000, "alternations; medians are reported"}},
    Bench{"jitter", "Wake-up latency of the servo's clock, compared with cyclictest", bench_jitter},
    Bench{"segment",
          "First hit of a dragged probe, compared with Embree, CGAL and Bullet",
          bench_segment,
          {3, 1000, "times each segment is asked"}},
    Bench{"line", "How long a device on a serial node takes to answer a line", bench_line},
    Bench{"lod",
          "Contact levels of detail against exact queries, voxels and a tool that never enters",
          bench_lod},
    Bench{"bake",
          "Trees and grid of a large mesh: built, and from the cache",
          bench_bake,
          {5, 100, "the fastest counts"}},
    Bench{"qp",
          "Hard contacts of one body: least constraint, pivoting, friction; compared with CGAL, "
          "Bullet",
          bench_qp,
          {3, 1000, "times each question is asked"}},
    Bench{"proximity",
          "Pairs of triangles within a band and their reduction to contacts, compared with FCL",
          bench_proximity},
    Bench{"penetration",
          "Penetration depth and distance of convex hulls, compared with Bullet, libccd and FCL",
          bench_penetration,
          {5, 1000, "alternations"}},
    Bench{"view",
          "What viewers of hapt view cost servo and bridge",
          bench_view,
          {5, 1000, "of all cases in turn; medians are reported"}},
    Bench{"world",
          "Objects with mass: sim's step beside Bullet's own; sessions with masses and without",
          bench_world,
          {5, 1000, "of sessions in turn; medians are reported"}},
    Bench{"rigid",
          "A tool that never enters an object, shaken against one; compared with FCL's distance",
          bench_rigid}};

void add(Command& benches, const Bench& bench) {
  struct Options {
    int rounds;
    bool json = false;
  };
  const auto options = std::make_shared<Options>(Options{bench.rounds.usual});
  Command command = benches.subcommand(bench.name, bench.help);
  const BenchRun run = bench.prepare(command);
  if (bench.rounds.most > 0) {
    command.option("--rounds", options->rounds, bench.rounds.help)
        .range(1, bench.rounds.most)
        .show_default();
  }
  add_json(command, options->json);
  command.example("hapt bench " + std::string(bench.name) + " --json");
  command.action([options, run] { print_judged(run(options->rounds), options->json); });
}

}  // namespace

void add_bench_command(Command& app) {
  Command benches = add_elsewhere(app, "bench");
  benches.require_subcommand();
  benches.example("hapt bench ring --rounds 3");
  for (const Bench& bench : kBenches) add(benches, bench);
}

}  // namespace haptic
