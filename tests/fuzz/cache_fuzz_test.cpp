// SPDX-License-Identifier: GPL-3.0-or-later
// Arbitrary cache files, even with a correct checksum: each is refused, or every query on its
// content stays within the arrays and ends. docs/fuzzing.md has the counts of a long run.
#include <array>
#include <catch2/catch.hpp>
#include <functional>

#include "contact/bake/convex/piece_tree.h"
#include "contact/bake/volume.h"
#include "contact/query/convex/piece_front.h"
#include "contact/query/point/closest_point.h"
#include "contact/query/point/segment_hit.h"
#include "contact/query/point/triangles_within.h"
#include "contact/query/sweep/swept_sphere.h"
#include "contact/query/volume/shell_in_field.h"
#include "contact/query/volume/voxel_scan.h"
#include "contact/shape/baked/file.h"
#include "contact/shape/baked/pieces.h"
#include "contact/shape/baked/volume.h"
#include "tests/fuzz/cache_damage.h"
#include "tests/support/convex/meshes.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {
namespace {

using namespace cache_damage;

Bytes shape_block() {
  const MeshShapeData shape = build_shape(make_icosphere(1, 2));
  const MeshData& eye = shape.mesh;
  return write_baked({shape.view(), eye.vertices, eye.vertex_normals, eye.triangles, {}}, kKey);
}

Bytes volume_block() {
  const MeshShapeData shape = build_shape(make_icosphere(1, 1));
  const VoxmapData map = build_voxmap(shape.mesh.view(), {0.1, 2});
  const DistanceFieldData field = build_distance_field(
      {-1, -1, -1}, {1, 1, 1}, [](const Vec3& p) { return norm(p) - 1; }, {0.1, 0.3, 0.3},
      run_in_turn, [](double) {});
  const PointshellData shell = build_pointshell(shape.mesh.view(), 0.2);
  return write_volume({map.view(), field.view(), shell.view()}, kKey);
}

/// Of a body with a concave edge: two pieces and their hull.
Bytes piece_block() {
  const MeshShapeData shape = build_shape(make_l_shape(1, 0.5));
  return write_pieces(build_piece_tree(shape.mesh.view()).view(), kKey);
}

void ask(const MeshShape& shape, Random& random) {
  std::array<ClosestPoint, 16> near;
  for (int i = 0; i < 3; ++i) {
    const Vec3 a = point_near(random), b = point_near(random);
    first_hit(shape, a, b);
    closest_point(shape, a, 1);
    first_sphere_hit(shape, {a, b, 0.1});
    triangles_within(shape, a, 0.5, near);
    triangles_facing(shape, b, 0.5, near);
  }
}

void ask(const VolumeContent& volume, Random& random) {
  Pose X_OT;
  X_OT.p = point_near(random);
  const Pointshell& shell = volume.shell;
  if (!volume.field.index.empty()) {
    for (int i = 0; i < 20; ++i) sample_field(volume.field, point_near(random));
    std::vector<ShellVisit> visited(shell.nodes.size() + 1);
    std::array<ShellTouch, 64> touches;
    ShellCoherence coherence(shell);
    ShellQuery query;
    query.reach = 0.1;
    if (!shell.nodes.empty()) {
      find_touches(volume.field, shell, X_OT, query, coherence, visited, touches);
    }
  }
  if (!volume.map.index.empty()) {
    std::vector<VoxelHit> hits(shell.x.size() + 64);
    const auto n = static_cast<uint32_t>(shell.x.size());
    scan_voxels(volume.map, shell, shell_in_voxels(volume.map, X_OT), 0, n, fastest_scan(), hits,
                0);
  }
}

void ask(const PieceTree& tree, Random& random) {
  static const MeshShapeData other = build_shape(make_icosphere(0.3, 1));
  static const PieceTreeData ball = build_piece_tree(other.mesh.view());
  constexpr uint32_t kNodes = 64;
  PieceFront front(tree, ball.view(), kNodes), reversed(ball.view(), tree, kNodes);
  RefineOptions options;
  options.tolerance = 0.1;
  options.budget = kNodes;
  for (int i = 0; i < 4; ++i) {
    Pose X;
    X.p = point_near(random);
    options.threshold = i % 2 == 0 ? 0 : 1e-3;
    const uint32_t leaf = tree.leaf_of[random() % tree.leaf_of.size()];
    const uint32_t of_ball = ball.leaf_of[random() % ball.leaf_of.size()];
    const std::array<TriangleMeeting, 1> meetings{{{leaf, of_ball, {}, {0, 0, 1}, 0.1}}};
    const std::array<TriangleMeeting, 1> swapped{{{of_ball, leaf, {}, {0, 0, 1}, 0.1}}};
    front.update(X, options);
    front.contacts(i % 2 == 0 ? std::optional<std::span<const TriangleMeeting>>(meetings)
                              : std::nullopt);
    reversed.update(X, options);
    reversed.contacts(swapped);
  }
}

/// What a cache may hold: its block, and questions to whatever its reader makes of such bytes.
struct Cached {
  BakedKind kind;
  size_t n_arrays;
  Bytes good;
  std::function<void(const Bytes&, Random&)> ask;

  bool is_taken(const Bytes& bytes, Random& random) const {
    try {
      ask(bytes, random);
      return true;
    } catch (const BakedFileError&) {
      return false;
    }
  }
  Bytes inside(Random& random) const { return damaged_inside(good, kind, n_arrays, random); }
};

Cached cached_shape() {
  return {BakedKind::kShape, 20, shape_block(),
          [](const Bytes& bytes, Random& random) { ask(view_baked(bytes, kKey).shape, random); }};
}

Cached cached_volume() {
  return {BakedKind::kVolume, 14, volume_block(),
          [](const Bytes& bytes, Random& random) { ask(view_volume(bytes, kKey), random); }};
}

Cached cached_pieces() {
  return {BakedKind::kPieces, 7, piece_block(),
          [](const Bytes& bytes, Random& random) { ask(view_pieces(bytes, kKey), random); }};
}

/// Numbers are changed and the checksum is right: some are refused, and the queries of the rest
/// end.
void check_inside(const char* name, uint64_t seed, const Cached& cached) {
  FuzzMeter meter(name, seed, kMostSeconds);
  meter.run(sweep(4000),
            [&](Random& random) { return cached.is_taken(cached.inside(random), random); });
  if (!meter.is_whole()) return;
  CHECK(meter.accepted() > 0);
  CHECK(meter.refused() > 0);
}

/// Files of any of these that are not what was written: all are refused.
void check_outside(const char* name, uint64_t seed, const std::vector<Cached>& kinds) {
  FuzzMeter meter(name, seed, kMostSeconds);
  meter.run(sweep(4000), [&](Random& random) {
    const Cached& cached = kinds[random() % kinds.size()];
    return cached.is_taken(damaged_outside(cached.good, random), random);
  });
  CHECK(meter.accepted() == 0);
}

}  // namespace

TEST_CASE("fuzz: cache of a shape with numbers changed is refused, or its queries end") {
  check_inside("fuzz: cache of a shape, right checksum", 2, cached_shape());
}

TEST_CASE("fuzz: cache of a volume with numbers changed is refused, or its queries end") {
  check_inside("fuzz: cache of a volume, right checksum", 3, cached_volume());
}

TEST_CASE("fuzz: cache of convex pieces with numbers changed is refused, or its queries end") {
  check_inside("fuzz: cache of pieces, right checksum", 5, cached_pieces());
}

TEST_CASE("fuzz: cache file that is not what was written is refused") {
  check_outside("fuzz: cache file damaged", 4, {cached_shape(), cached_volume()});
}

TEST_CASE("fuzz: cache file of convex pieces that is not what was written is refused") {
  check_outside("fuzz: cache file of pieces damaged", 6, {cached_pieces()});
}

}  // namespace haptic::test
