// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/voxel_tree.h"

#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kRadius = 0.05;

VoxmapData map_of(const Soup& soup, double size) {
  return build_voxmap(build_shape(soup).mesh.view(), {size, 2});
}

size_t voxels_in(const VoxmapData& map) {
  return map.index.size() * kBrickSide * kBrickSide * kBrickSide;
}

}  // namespace

TEST_CASE("voxel tree: every voxel is that of the map, and free around it", "[contact]") {
  // one child of the root; many; and a long map that is one child wide
  const auto [soup, size] = GENERATE(table<Soup, double>({
      {make_icosphere(kRadius, 2), 4e-3},
      {make_icosphere(kRadius, 2), 0.8e-3 * (kSlowdown > 1 ? 2 : 1)},
      {make_box({0.2, 0.02, 0.01}), 1e-3},
  }));
  const VoxmapData map = map_of(soup, size);
  const VoxelTreeData tree = build_voxel_tree(map.view());
  size_t wrong = 0, of_kind[4] = {};
  const auto side = [&](size_t k) { return map.bricks[k] * kBrickSide; };
  VoxelIndex i;
  for (i[2] = -9; i[2] < side(2) + 70; ++i[2]) {
    for (i[1] = -9; i[1] < side(1) + 70; ++i[1]) {
      for (i[0] = -9; i[0] < side(0) + 70; ++i[0]) {
        const Voxel voxel = map.view().at(i);
        wrong += tree.view().at(i) != voxel;
        ++of_kind[static_cast<size_t>(voxel)];
      }
    }
  }
  CHECK(wrong == 0);
  for (const size_t n : of_kind) CHECK(n > 0);
}

TEST_CASE("voxel tree: bricks and nodes that are all one are one", "[contact]") {
  const VoxmapData map = map_of(make_icosphere(kRadius, 3), 0.8e-3);
  const VoxelTreeData tree = build_voxel_tree(map.view());
  CHECK(tree.bricks.size() <= map.data.size());
  for (size_t i = 2; i < tree.bricks.size(); ++i) {
    REQUIRE(!(tree.bricks[i] == tree.bricks[0]));
    REQUIRE(!(tree.bricks[i] == tree.bricks[1]));
  }
  for (size_t i = 2; i < tree.nodes.size(); ++i) {
    REQUIRE(tree.nodes[i] != tree.nodes[0]);
    REQUIRE(tree.nodes[i] != tree.nodes[1]);
  }
}

TEST_CASE("voxel tree: a fraction of a dense map's memory", "[contact]") {
  if (kSlowdown > 1) return;
  // 1/256 of the box [McNeely, Puterbaugh, Troy 1999]; dense storage takes two bits per voxel
  const VoxmapData map = map_of(make_icosphere(kRadius, 4), 2 * kRadius / 256);
  const VoxelTreeData tree = build_voxel_tree(map.view());
  CAPTURE(tree.bytes(), map.bytes(), voxels_in(map) / 4);
  CHECK(3 * tree.bytes() < voxels_in(map) / 4);
  CHECK(build_voxel_tree({}).bricks.empty());
}

TEST_CASE("voxel tree: looked up, it gives what its map gives", "[lab]") {
  const MeshShapeData object = build_shape(make_icosphere(0.05, 3));
  const VoxmapData map = build_voxmap(object.mesh.view(), {1.3e-3, 2});
  const VoxelTreeData tree = build_voxel_tree(map.view());
  const PointshellData shell = build_pointshell(object.mesh.view(), 2.3e-3);
  Random random(3);
  size_t touching = 0;
  for (size_t k = 0; k < trials(300); ++k) {
    const Pose X_OT = random.pose(random.uniform(0, 0.12));
    const ShellInVoxels at = shell_in_voxels(map.view(), X_OT);
    const auto all = static_cast<uint32_t>(shell.x.size());
    std::vector<VoxelHit> hits(all), expected(all);
    hits.resize(scan_voxels(tree.view(), shell.view(), at, 0, all, hits, 0));
    expected.resize(
        scan_voxels(map.view(), shell.view(), at, 0, all, ScanPath::kScalar, expected, 0));
    REQUIRE(hits.size() == expected.size());
    for (size_t i = 0; i < hits.size(); ++i) REQUIRE(hits[i].packed == expected[i].packed);
    touching += hits.size();
  }
  CHECK(touching > 0);
}
