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
#include "tests/fuzz/fuzz_meter.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {
namespace {

using Bytes = std::vector<std::byte>;
using Random = FuzzMeter::Random;

constexpr uint64_t kKey = 7;
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

/// A number at an edge of its type or of the arrays, or a random one.
uint64_t odd_number(Random& random) {
  static constexpr uint64_t kNumbers[] = {0,
                                          1,
                                          0x7fffffff,
                                          0x80000000,
                                          0xffffffff,
                                          0x7f800000,
                                          0x7fc00000,
                                          0x7ff0000000000000,
                                          0x7ff8000000000000,
                                          0x3ff0000000000000,
                                          0x7fefffffffffffff,
                                          0xffffffffffffffff};
  switch (random() % 3) {
    case 0:
      return kNumbers[random() % std::size(kNumbers)];
    case 1:
      return random() % 1000;
    default:
      return random();
  }
}

void damage(Bytes& array, Random& random) {
  if (array.empty() || random() % 16 == 0) {
    array.resize(random() % (array.size() + 64) / 8 * 8);
    return;
  }
  const size_t size = std::min(array.size(), size_t{1} << random() % 4);
  const size_t at = random() % (array.size() / size) * size;
  const uint64_t number = odd_number(random);
  std::memcpy(array.data() + at, &number, size);
}

/// The block with a few numbers changed and the checksum corrected.
Bytes damaged_inside(const Bytes& good, BakedKind kind, size_t n_arrays, Random& random) {
  const BakedBlock block = view_block(good, kind, kKey, n_arrays);
  std::vector<Bytes> arrays;
  for (size_t i = 0; i < n_arrays; ++i) {
    arrays.emplace_back(block.arrays[i].begin(), block.arrays[i].end());
  }
  for (uint64_t n = 1 + random() % 4; n > 0; --n) damage(arrays[random() % n_arrays], random);
  std::vector<std::span<const std::byte>> views(arrays.begin(), arrays.end());
  return write_block(kind, kKey, views);
}

/// The file damaged, cut or extended; never unchanged.
Bytes damaged_outside(const Bytes& good, Random& random) {
  for (;;) {
    Bytes bytes = good;
    if (random() % 4 == 0) bytes.resize(random() % (good.size() + 100));
    for (uint64_t n = random() % 4; n > 0 && !bytes.empty(); --n) {
      // the header more often than the arrays
      const size_t range = random() % 2 == 0 ? std::min<size_t>(bytes.size(), 512) : bytes.size();
      bytes[random() % range] = static_cast<std::byte>(random());
    }
    if (bytes != good) return bytes;
  }
}

Vec3 point_near(Random& random) {
  std::uniform_real_distribution<double> u(-1.5, 1.5);
  return {u(random), u(random), u(random)};
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
