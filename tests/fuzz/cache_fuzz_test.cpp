// SPDX-License-Identifier: GPL-3.0-or-later
// Arbitrary cache files, even with a correct checksum: each is refused, or every query on its
// content stays within the arrays and ends. docs/fuzzing.md has the counts of a long run.
#include <array>
#include <catch2/catch.hpp>
#include <cstring>

#include "contact/bake/volume.h"
#include "contact/query/point/closest_point.h"
#include "contact/query/point/segment_hit.h"
#include "contact/query/point/triangles_within.h"
#include "contact/query/sweep/swept_sphere.h"
#include "contact/query/volume/shell_in_field.h"
#include "contact/query/volume/voxel_scan.h"
#include "contact/shape/baked/file.h"
#include "contact/shape/baked/volume.h"
#include "tests/fuzz/cache_damage.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {
namespace {

using namespace cache_damage;

constexpr unsigned kSeconds = kSlowdown > 1 ? 20 : 2;  // CPU time limit of an input [s]
constexpr size_t kShapeArrays = 20, kVolumeArrays = 14;

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
    ShellQuery query;
    query.reach = 0.1;
    if (!shell.nodes.empty()) {
      find_touches(volume.field, shell, X_OT, query, nullptr, visited, touches);
    }
  }
  if (!volume.map.index.empty()) {
    std::vector<VoxelHit> hits(shell.x.size() + 64);
    const auto n = static_cast<uint32_t>(shell.x.size());
    scan_voxels(volume.map, shell, shell_in_voxels(volume.map, X_OT), 0, n, fastest_scan(), hits,
                0);
  }
}

bool is_shape_taken(const Bytes& bytes, Random& random) {
  try {
    ask(view_baked(bytes, kKey).shape, random);
    return true;
  } catch (const BakedFileError&) {
    return false;
  }
}

bool is_volume_taken(const Bytes& bytes, Random& random) {
  try {
    ask(view_volume(bytes, kKey), random);
    return true;
  } catch (const BakedFileError&) {
    return false;
  }
}

}  // namespace

TEST_CASE("fuzz: cache of a shape with numbers changed is refused, or its queries end") {
  const Bytes good = shape_block();
  FuzzMeter meter("fuzz: cache of a shape, right checksum", 2, kSeconds);
  meter.run(sweep(4000), [&](Random& random) {
    return is_shape_taken(damaged_inside(good, BakedKind::kShape, kShapeArrays, random), random);
  });
  if (!meter.is_whole()) return;
  CHECK(meter.accepted() > 0);
  CHECK(meter.refused() > 0);
}

TEST_CASE("fuzz: cache of a volume with numbers changed is refused, or its queries end") {
  const Bytes good = volume_block();
  FuzzMeter meter("fuzz: cache of a volume, right checksum", 3, kSeconds);
  meter.run(sweep(4000), [&](Random& random) {
    return is_volume_taken(damaged_inside(good, BakedKind::kVolume, kVolumeArrays, random), random);
  });
  if (!meter.is_whole()) return;
  CHECK(meter.accepted() > 0);
  CHECK(meter.refused() > 0);
}

TEST_CASE("fuzz: cache file that is not what was written is refused") {
  const Bytes shape = shape_block(), volume = volume_block();
  FuzzMeter meter("fuzz: cache file damaged", 4, kSeconds);
  meter.run(sweep(4000), [&](Random& random) {
    return random() % 2 == 0 ? is_shape_taken(damaged_outside(shape, random), random)
                             : is_volume_taken(damaged_outside(volume, random), random);
  });
  CHECK(meter.accepted() == 0);
}

}  // namespace haptic::test
