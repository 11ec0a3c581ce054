// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include "clients/lab/bench/peers/closest.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/bench/workloads/workload.h"
#include "clients/lab/support/scan.h"
#include "contact/bake/bake.h"
#include "contact/query/point/closest_point.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "proto/config/command_line.h"

namespace haptic {
namespace {

constexpr double kAnyDistance = std::numeric_limits<double>::infinity();
constexpr size_t kChunk = 200;        // queries of one contestant per turn
constexpr size_t kBruteForced = 100;  // points checked by brute force

struct Options {
  int rounds = 3;
  std::string meshes;  // folder with armadillo.off; skipped if empty
};

/// The points of one measurement.
struct Trial {
  std::string name;
  const WorkloadMesh& mesh;
  const MeshShape& shape;
  std::vector<Vec3> points;
};

/// Largest difference from brute force over all triangles, on every n-th point.
double error_of(const Trial& trial, const std::vector<double>& distances) {
  double error = 0;
  const size_t stride = std::max<size_t>(trial.points.size() / kBruteForced, 1);
  for (size_t i = 0; i < trial.points.size(); i += stride) {
    double least = kAnyDistance;
    for (uint32_t t = 0; t < trial.shape.mesh.triangles.size(); ++t) {
      const ClosestPoint c = closest_point_on_triangle(trial.shape.mesh, t, trial.points[i]);
      least = std::min(least, c.distance);
    }
    error = std::max(error, std::fabs(distances[i] - least));
  }
  return error;
}

void run_trial(const Trial& trial, int rounds, bool is_far, const Rows& all) {
  ClosestWitness witness;
  const size_t n = trial.points.size();
  std::vector<std::vector<double>> answers;
  std::vector<Contestant> contestants;
  const auto enter = [&](const std::string& name, std::function<double(const Vec3&)> distance) {
    answers.emplace_back(n);
    const size_t k = answers.size() - 1;
    contestants.push_back({name, [&, k, distance = std::move(distance)](size_t i) {
                             answers[k][i] = distance(trial.points[i]);
                           }});
  };
  enter("with witness", [&](const Vec3& p) {
    return closest_point(trial.shape, p, kAnyDistance, witness).distance;
  });
  enter("without witness",
        [&](const Vec3& p) { return closest_point(trial.shape, p, kAnyDistance).distance; });
  const size_t ours = contestants.size();
  for (const ClosestPeer& peer : embree_peers(trial.shape.mesh)) enter(peer.name, peer.distance);
  const bool embree = contestants.size() > ours;
  for (const ClosestPeer& peer : cgal_peers(trial.shape.mesh)) enter(peer.name, peer.distance);
  take_turns(contestants, n, kChunk, rounds);

  Rows rows = all.of(trial.name);
  const std::string prefix = trial.name + ", ";
  for (size_t k = 0; k < contestants.size(); ++k) {
    const Contestant& c = contestants[k];
    const double error = error_of(trial, answers[k]);
    rows.add({{prefix + c.name + " p50", percentile(c.times, 50), "s"},
              {prefix + c.name + " p99", percentile(c.times, 99), "s"},
              {prefix + c.name + ", error against brute force", error, "m",
               k < ours ? kMustBeZero : Goal{}}});
  }
  size_t different = 0;
  for (size_t i = 0; i < n; ++i) different += answers[0][i] != answers[1][i];
  rows.add(prefix + "changed by the witness", different, "", kMustBeZero);
  if (is_far) {
    // two equal contestants differ by about 1 % here
    const double ratio = median_ratio(contestants[0], contestants[1]);
    rows.add(prefix + "with over without witness", ratio, "", at_most(1.02));
  } else if (embree) {
    const double ratio =
        percentile(contestants[0].times, 50) / percentile(contestants[ours].times, 50);
    rows.add(prefix + "median over Embree's with previous radius", ratio, "", at_most(0.4));
  }
  if (!embree) rows.note(prefix + "Embree", "LEFT OUT: ./run bench closest installs it");
}

void run_mesh(const WorkloadMesh& mesh, int rounds, const Rows& all) {
  const MeshData data = build_mesh(mesh.soup.vertices, mesh.soup.triangles);
  const ObbTreeData tree = build_obb_tree(data.view());
  const PatchTreeData patches = build_patch_tree(data.view());
  const MeshShape shape{data.view(), tree.view(), {}, patches.view()};
  Rows rows = all.of(mesh.name);
  const size_t bytes =
      patches.nodes.size() * sizeof(PatchNode) + patches.leaves.size() * sizeof(PatchLeaf);
  rows.add(mesh.name + ", bytes a triangle",
           static_cast<double>(bytes) / static_cast<double>(data.triangles.size()), "B",
           given(40, bytes <= 40 * data.triangles.size()));
  const Trial dragged{mesh.name + " dragged", mesh, shape, dragged_points(shape, mesh.kind, 20000)};
  run_trial(dragged, rounds, false, all);
  const Trial far{mesh.name + " far", mesh, shape, far_points(shape, mesh.kind, 4000)};
  run_trial(far, rounds, true, all);
}

void all_rows(const Options& options, const Rows& all) {
  Rows rows = all.machine("closest");
  rows.add("rounds", options.rounds);
  for (const uint32_t frequency : {64u, 128u}) {
    run_mesh(make_bump_sphere(frequency), options.rounds, all);
  }
  const std::string armadillo = options.meshes + "/armadillo.off";
  if (std::filesystem::exists(armadillo)) {
    run_mesh(read_scanned("armadillo", armadillo), options.rounds, all);
  } else {
    rows.note("armadillo", "LEFT OUT: " + armadillo + " is not here; ./run meshes fetches it");
  }
}

}  // namespace

/// Cost of the closest point on a mesh, with and without warm start, compared with Embree's point
/// query and CGAL's AABB tree. Workload W2: points dragged within 1 mm of the surface, and random
/// ones up to 20 mm outside. Errors are against brute force on a sample, and on all points between
/// the answers with and without warm start.
Measured bench_closest(Command& command) {
  const auto options = std::make_shared<Options>();
  options->meshes = meshes_folder();
  command.option("--meshes FOLDER", options->meshes, "folder with armadillo.off").show_default();
  add_counts(command, {rounds_of(options->rounds, "passes over all points")});
  return measured(all_rows, options);
}

}  // namespace haptic
