// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/query_costs.h"

#include <algorithm>

#include "contact/query/point/cell_walk.h"
#include "contact/query/point/segment_hit.h"
#include "contact/shape/baked/mesh_shape.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int kRounds = 7;
constexpr size_t kRepeats = 2000;
constexpr size_t kStride = 7919;  // a prime: from one end of the mesh to the other

/// The parts of first_hit one by one, on segments through the surface of a mesh. Each returns
/// something that depends on all the work.
class SegmentCostProbe {
 public:
  /// The shape must live longer; it has a grid.
  explicit SegmentCostProbe(const MeshShape& shape) : shape_(shape) {}
  uint64_t look_up(size_t i) const;        // one cell of a walk, found
  uint64_t test_batch(size_t i) const;     // eight thin boxes
  uint64_t test_triangle(size_t i) const;  // one triangle

 private:
  MeshShape shape_;
};

uint64_t SegmentCostProbe::look_up(size_t i) const {
  const Vec3 from_O = 1.01 * shape_.mesh.vertices[i % shape_.mesh.vertices.size()];
  CellWalk walk;
  if (!walk.start(shape_.grid, from_O, -0.02 * from_O)) return 0;
  return shape_.grid.find(walk.key()).batches.size();
}

uint64_t SegmentCostProbe::test_batch(size_t i) const {
  const double x = static_cast<double>(i % 7) * 0.05;
  const CellProbe part({x, -x, 0.1}, {-x, x, -0.1});
  return part.may_meet(shape_.grid.batches[i % shape_.grid.batches.size()]);
}

uint64_t SegmentCostProbe::test_triangle(size_t i) const {
  const auto& [a, b, c] = shape_.mesh.triangles[i % shape_.mesh.triangles.size()];
  const auto& v = shape_.mesh.vertices;
  const Vec3 from_O = 1.01 * v[a];
  double t = 0;
  return segment_enters_triangle(from_O, from_O - 0.02 * v[b], v[a], v[b], v[c], t) ? 1 : 0;
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

}  // namespace

QueryCosts measure_query_costs() {
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

}  // namespace haptic
