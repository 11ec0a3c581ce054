// SPDX-License-Identifier: GPL-3.0-or-later
// hapt bench: figures of this machine, beside a peer that runs in alternation with us.
#include <CLI/CLI.hpp>
#include <memory>

#include "clients/bench_bake.h"
#include "clients/bench_ccd.h"
#include "clients/bench_closest.h"
#include "clients/bench_jitter.h"
#include "clients/bench_point_proxy.h"
#include "clients/bench_proximity.h"
#include "clients/bench_qp.h"
#include "clients/bench_rigid.h"
#include "clients/bench_ring.h"
#include "clients/bench_segment.h"
#include "clients/bench_voxel.h"
#include "clients/hapt_commands.h"
#include "clients/print_rows.h"
#include "proto/environment.h"

namespace haptic {
namespace {

void add_ring_command(CLI::App& bench) {
  struct Options {
    BenchRingOptions ring;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = bench.add_subcommand(
      "ring", "The channel between processes beside boost::lockfree::spsc_queue");
  command->add_option("--rounds", options->ring.rounds, "alternations; medians are reported")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "rows as JSON");
  command->callback([options] { print_judged(bench_ring(options->ring), options->json); });
}

void add_closest_command(CLI::App& bench) {
  struct Options {
    BenchClosestOptions closest;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  options->closest.meshes = environment("HAPTICD_MESHES");
  if (options->closest.meshes.empty()) {
    options->closest.meshes = HAPTICD_SOURCE_DIR "/build/meshes";
  }
  CLI::App* command = bench.add_subcommand(
      "closest", "The closest point of a mesh beside Embree's point query and CGAL's AABB tree");
  command->add_option("--rounds", options->closest.rounds, "passes over all points")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--meshes", options->closest.meshes, "folder with armadillo.off")
      ->capture_default_str();
  command->add_flag("--json", options->json, "rows as JSON");
  command->callback([options] { print_judged(bench_closest(options->closest), options->json); });
}

void add_ccd_command(CLI::App& bench) {
  struct Options {
    BenchCcdOptions ccd;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  if (const std::string data = environment("HAPTICD_DATA"); !data.empty()) {
    options->ccd.queries = data + "/ccd-queries";
  }
  CLI::App* command = bench.add_subcommand(
      "ccd", "Continuous collision of features and of meshes beside FCL and Redon's intervals");
  command->add_option("--queries", options->ccd.queries, "folder of ground-truth queries")
      ->capture_default_str();
  command->add_option("--rounds", options->ccd.rounds, "alternations")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--motions", options->ccd.motions, "of the two tori")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "rows as JSON");
  command->callback([options] { print_judged(bench_ccd(options->ccd), options->json); });
}

void add_point_proxy_command(CLI::App& bench) {
  struct Options {
    BenchPointProxyOptions proxy;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = bench.add_subcommand(
      "point-proxy", "A whole contact step, dragged over meshes of 5 k to 1.1 M triangles");
  command->add_option("--mesh", options->proxy.meshes, "hf:N or sphere:N, as often as wanted")
      ->check([](const std::string& name) {
        return is_eval_work(name) ? "" : "give hf:N, sphere:N or flat:N";
      });
  command->add_option("--radius", options->proxy.radii, "of the proxy [m], as often as wanted")
      ->check(CLI::Range(0.0, 0.05))
      ->capture_default_str();
  command
      ->add_option("--repetitions", options->proxy.repetitions, "the fastest of each tick counts")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_flag("--json", options->json, "rows as JSON");
  command->callback([options] { print_judged(bench_point_proxy(options->proxy), options->json); });
}

void add_voxel_command(CLI::App& bench) {
  struct Options {
    BenchVoxelOptions voxel;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  BenchVoxelOptions& voxel = options->voxel;
  CLI::App* command = bench.add_subcommand(
      "voxel", "Points of a shell in a voxmap, beside bare gathers, and contact steps, beside FCL");
  command->add_option("--side", voxel.sides, "voxels along the object, as often as wanted")
      ->check(CLI::Range(8, 4096));
  command->add_option("--points", voxel.points, "of the shell, as often as wanted")
      ->check(CLI::Range(100, 4'000'000));
  command->add_option("--coarse", voxel.coarse, "object of 20 f² triangles")
      ->check(CLI::Range(1, 1500))
      ->capture_default_str();
  command->add_option("--fine", voxel.fine, "the same beside it, finer")
      ->check(CLI::Range(1, 1500))
      ->capture_default_str();
  command->add_option("--rounds", voxel.rounds, "alternations; medians are reported")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--memory-side", voxel.memory_side, "voxels along the bunny, 0: none")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  command->add_option("--pair", voxel.contact.pairs, "of whole contact steps; as often as wanted")
      ->check(CLI::IsMember({"bolt", "free-bolt", "peg", "jaws"}));
  command->add_option("--coarser", voxel.contact.coarser, "times that their voxels and points are")
      ->check(CLI::Range(1.0, 100.0))
      ->capture_default_str();
  command->add_option("--ticks", voxel.contact.ticks, "contact steps of a pair")
      ->check(CLI::Range(100, 1'000'000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "rows as JSON");
  command->callback([options] { print_judged(bench_voxel(options->voxel), options->json); });
}

}  // namespace

void add_bench_command(CLI::App& app) {
  CLI::App* bench =
      app.add_subcommand("bench", "Measure this machine; exit 1 where a goal is missed");
  bench->require_subcommand(1);
  add_ring_command(*bench);
  add_ccd_command(*bench);
  add_closest_command(*bench);
  add_point_proxy_command(*bench);
  add_voxel_command(*bench);
  add_bench_jitter(*bench);
  add_bench_segment(*bench);
  add_bench_bake(*bench);
  add_bench_qp(*bench);
  add_bench_proximity(*bench);
  add_bench_rigid(*bench);
}

}  // namespace haptic
