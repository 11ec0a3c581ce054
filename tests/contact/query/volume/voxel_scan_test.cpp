// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/volume/voxel_scan.h"

#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

std::vector<VoxelHit> scan(const Voxmap& map, const Pointshell& shell, const Pose& X_OT,
                           ScanPath path, uint32_t first = 0) {
  std::vector<VoxelHit> hits(shell.x.size() + 64);  // padded for SIMD
  const auto count = static_cast<uint32_t>(shell.x.size()) - first;
  hits.resize(scan_voxels(map, shell, shell_in_voxels(map, X_OT), first, count, path, hits, 0));
  return hits;
}

}  // namespace

TEST_CASE("voxel scan: every point is in the voxel where it is", "[contact]") {
  const MeshShapeData object = build_shape(make_icosphere(0.05, 3)),
                      tool = build_shape(make_box({0.03, 0.05, 0.02}));
  const VoxmapData map = build_voxmap(object.mesh.view(), {1.3e-3, 2});
  const PointshellData shell = build_pointshell(tool.mesh.view(), 1e-3);
  Random random(1);
  size_t touching = 0, on_border = 0;
  for (size_t k = 0; k < trials(200); ++k) {
    const Pose X_OT = random.pose(0.07);
    const std::vector<VoxelHit> hits = scan(map.view(), shell.view(), X_OT, ScanPath::kScalar);
    size_t next = 0;
    for (uint32_t i = 0; i < shell.x.size(); ++i) {
      const Vec3 p{static_cast<double>(shell.x[i]), static_cast<double>(shell.y[i]),
                   static_cast<double>(shell.z[i])};
      const Vec3 q = (X_OT * p - map.lower_O) / map.size;
      const bool near_border = [&] {
        for (int a = 0; a < 3; ++a) {
          if (std::fabs(q[a] - std::round(q[a])) < 1e-4) return true;
        }
        return false;
      }();
      const bool listed = next < hits.size() && hits[next].point() == i;
      const Voxel found = listed ? hits[next].voxel() : Voxel::kFree;
      next += listed;
      on_border += near_border;
      if (!near_border) REQUIRE(found == map.view().at(map.view().index_of(X_OT * p)));
    }
    REQUIRE(next == hits.size());
    touching += hits.size();
  }
  CHECK(touching > 0);
  CHECK(on_border < trials(200) * shell.x.size() / 100);
}

TEST_CASE("voxel scan: eight at a time is the same to the bit", "[contact][trap]") {
  if (fastest_scan() == ScanPath::kScalar) {
    WARN("SKIPPED: no AVX2 here");
    return;
  }
  const MeshShapeData object = build_shape(make_icosphere(0.05, 3));
  // in the coarse one even the first brick is not free
  const double size = GENERATE(1.3e-3, 40e-3);
  const VoxmapData map = build_voxmap(object.mesh.view(), {size, 0});
  const PointshellData shell = build_pointshell(object.mesh.view(), 1.1e-3);
  Random random(2);
  size_t touching = 0, free = 0;
  for (size_t k = 0; k < trials(300); ++k) {
    const Pose X_OT = random.pose(random.uniform(0, 0.3));
    const auto first = static_cast<uint32_t>(random.index(20));
    const auto one = scan(map.view(), shell.view(), X_OT, ScanPath::kScalar, first);
    const auto lanes = scan(map.view(), shell.view(), X_OT, ScanPath::kLanes, first);
    REQUIRE(one.size() == lanes.size());
    for (size_t i = 0; i < one.size(); ++i) REQUIRE(one[i].packed == lanes[i].packed);
    touching += one.size();
    free += shell.x.size() - first - one.size();
  }
  CHECK(touching > 0);
  CHECK(free > 0);
}

TEST_CASE("voxel scan: hits stop where there is no room", "[contact]") {
  const MeshShapeData object = build_shape(make_icosphere(0.05, 2));
  const VoxmapData map = build_voxmap(object.mesh.view(), {2e-3, 2});
  const PointshellData shell = build_pointshell(object.mesh.view(), 2e-3);
  const ScanPath path = GENERATE(ScanPath::kScalar, ScanPath::kLanes);
  if (path == ScanPath::kLanes && fastest_scan() != path) return;
  for (const size_t room : {size_t{0}, size_t{5}, size_t{13}, size_t{100}}) {
    std::vector<VoxelHit> hits(room);
    const size_t n = scan_voxels(map.view(), shell.view(), shell_in_voxels(map.view(), {}), 0,
                                 static_cast<uint32_t>(shell.x.size()), path, hits, 0);
    CHECK(n == room);
    const auto all = scan(map.view(), shell.view(), {}, ScanPath::kScalar);
    for (size_t i = 0; i < n; ++i) REQUIRE(hits[i].packed == all[i].packed);
  }
}
