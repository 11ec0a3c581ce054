// SPDX-License-Identifier: GPL-3.0-or-later
// hapt bench: measures this machine, in alternation with a peer library.
#include <array>
#include <memory>

#include "clients/bench/benches.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/lab_commands.h"
#include "clients/report/print_rows.h"
#include "proto/config/command_line.h"

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
          "The channel between processes beside boost::lockfree::spsc_queue",
          bench_ring,
          {5, 1000, "alternations; medians are reported"}},
    Bench{"ccd",
          "Continuous collision of features and of meshes beside FCL and Redon's intervals",
          bench_ccd,
          {5, 1000, "alternations"}},
    Bench{"closest",
          "The closest point of a mesh beside Embree's point query and CGAL's AABB tree",
          bench_closest,
          {3, 1000, "passes over all points"}},
    Bench{"point-proxy", "A whole contact step, dragged over meshes of 5 k to 1.1 M triangles",
          bench_point_proxy},
    Bench{"voxel",
          "Points of a shell in a voxmap, beside bare gathers, and contact steps, beside FCL",
          bench_voxel,
          {15, 1000, "alternations; medians are reported"}},
    Bench{"jitter", "How late the servo's clock wakes, beside cyclictest, in alternation",
          bench_jitter},
    Bench{"segment",
          "First hit of a dragged probe, beside Embree, CGAL and Bullet",
          bench_segment,
          {3, 1000, "times each segment is asked"}},
    Bench{"bake",
          "Trees and grid of a large mesh: built, and from the cache",
          bench_bake,
          {5, 100, "the fastest counts"}},
    Bench{"qp",
          "Hard contacts of one body: least constraint, pivoting, friction; beside CGAL, Bullet",
          bench_qp,
          {3, 1000, "times each question is asked"}},
    Bench{"proximity",
          "Pairs of triangles within a band, and contacts that stand for them, beside FCL",
          bench_proximity},
    Bench{"rigid", "A tool that never enters an object, shaken against one; beside FCL's distance",
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
  command.flag("--json", options->json, "rows as JSON");
  command.action([options, run] { print_judged(run(options->rounds), options->json); });
}

}  // namespace

void add_bench_command(Command& app) {
  Command benches = app.subcommand(kBenchCommand.name, kBenchCommand.help);
  benches.require_subcommand();
  for (const Bench& bench : kBenches) add(benches, bench);
}

}  // namespace haptic
