// SPDX-License-Identifier: GPL-3.0-or-later
// hapt bench: measures this machine, in alternation with a peer library.
#include <memory>

#include "clients/bench/bake.h"
#include "clients/bench/ccd.h"
#include "clients/bench/closest.h"
#include "clients/bench/jitter.h"
#include "clients/bench/point_proxy.h"
#include "clients/bench/proximity.h"
#include "clients/bench/qp.h"
#include "clients/bench/rigid.h"
#include "clients/bench/ring.h"
#include "clients/bench/segment.h"
#include "clients/bench/voxel.h"
#include "clients/eval/scenes/rigid_scenes.h"
#include "clients/hapt/commands.h"
#include "clients/hapt/lab_commands.h"
#include "clients/report/print_rows.h"
#include "proto/config/command_line.h"
#include "proto/os/environment.h"

namespace haptic {
namespace {

void add_ring_command(Command& bench) {
  struct Options {
    BenchRingOptions ring;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  Command command =
      bench.subcommand("ring", "The channel between processes beside boost::lockfree::spsc_queue");
  command.option("--rounds", options->ring.rounds, "alternations; medians are reported")
      .range(1, 1000)
      .show_default();
  command.flag("--json", options->json, "rows as JSON");
  command.action([options] { print_judged(bench_ring(options->ring), options->json); });
}

void add_closest_command(Command& bench) {
  struct Options {
    BenchClosestOptions closest;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  options->closest.meshes = meshes_folder();
  Command command = bench.subcommand(
      "closest", "The closest point of a mesh beside Embree's point query and CGAL's AABB tree");
  command.option("--rounds", options->closest.rounds, "passes over all points")
      .range(1, 1000)
      .show_default();
  command.option("--meshes", options->closest.meshes, "folder with armadillo.off").show_default();
  command.flag("--json", options->json, "rows as JSON");
  command.action([options] { print_judged(bench_closest(options->closest), options->json); });
}

void add_ccd_command(Command& bench) {
  struct Options {
    BenchCcdOptions ccd;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  if (const std::string data = environment("HAPTICD_DATA"); !data.empty()) {
    options->ccd.queries = data + "/ccd-queries";
  }
  Command command = bench.subcommand(
      "ccd", "Continuous collision of features and of meshes beside FCL and Redon's intervals");
  command.option("--queries", options->ccd.queries, "folder of ground-truth queries")
      .show_default();
  command.option("--rounds", options->ccd.rounds, "alternations").range(1, 1000).show_default();
  command.option("--motions", options->ccd.motions, "of the two tori")
      .range(1, 100000)
      .show_default();
  command.flag("--json", options->json, "rows as JSON");
  command.action([options] { print_judged(bench_ccd(options->ccd), options->json); });
}

void add_point_proxy_command(Command& bench) {
  struct Options {
    BenchPointProxyOptions proxy;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  Command command = bench.subcommand(
      "point-proxy", "A whole contact step, dragged over meshes of 5 k to 1.1 M triangles");
  command.option("--mesh", options->proxy.meshes, "hf:N or sphere:N, as often as wanted")
      .check([](const std::string& name) {
        return is_eval_work(name) ? "" : "give hf:N, sphere:N or flat:N";
      });
  command
      .quantities("--radius", options->proxy.radii, Dimension::kLength, {0, 0.05},
                  "of the proxy, as often as wanted; a number alone: metres", "m")
      .show_default();
  command.option("--repetitions", options->proxy.repetitions, "the fastest of each tick counts")
      .range(1, 100)
      .show_default();
  command.flag("--json", options->json, "rows as JSON");
  command.action([options] { print_judged(bench_point_proxy(options->proxy), options->json); });
}

void add_voxel_command(Command& bench) {
  struct Options {
    BenchVoxelOptions voxel;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  BenchVoxelOptions& voxel = options->voxel;
  Command command = bench.subcommand(
      "voxel", "Points of a shell in a voxmap, beside bare gathers, and contact steps, beside FCL");
  command.option("--side", voxel.sides, "voxels along the object, as often as wanted")
      .range(8, 4096);
  command.option("--points", voxel.points, "of the shell, as often as wanted")
      .range(100, 4'000'000);
  command.option("--coarse", voxel.coarse, "object of 20 f² triangles")
      .range(1, 1500)
      .show_default();
  command.option("--fine", voxel.fine, "the same beside it, finer").range(1, 1500).show_default();
  command.option("--rounds", voxel.rounds, "alternations; medians are reported")
      .range(1, 1000)
      .show_default();
  command.option("--memory-side", voxel.memory_side, "voxels along the bunny, 0: none")
      .range(0, 4096)
      .show_default();
  command.option("--pair", voxel.contact.pairs, "of whole contact steps; as often as wanted")
      .one_of({"bolt", "free-bolt", "peg", "jaws"});
  command
      .number("--coarser", voxel.contact.coarser, {1, 100},
              "times that their voxels and points are")
      .show_default();
  command.option("--ticks", voxel.contact.ticks, "contact steps of a pair")
      .range(100, 1'000'000)
      .show_default();
  command.flag("--json", options->json, "rows as JSON");
  command.action([options] { print_judged(bench_voxel(options->voxel), options->json); });
}

}  // namespace

void add_bench_command(Command& app) {
  Command bench = app.subcommand(kBenchCommand.name, kBenchCommand.help);
  bench.require_subcommand();
  add_ring_command(bench);
  add_ccd_command(bench);
  add_closest_command(bench);
  add_point_proxy_command(bench);
  add_voxel_command(bench);
  add_bench_jitter(bench);
  add_bench_segment(bench);
  add_bench_bake(bench);
  add_bench_qp(bench);
  add_bench_proximity(bench);
  add_bench_rigid(bench);
}

}  // namespace haptic
