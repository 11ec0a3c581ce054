// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/volume/voxmap.h"

#include <map>

#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// The kind of every voxel, from the definition: no bricks, no lists.
struct DenseMap {
  VoxelIndex side{};
  std::vector<Voxel> voxels;
  Voxel& at(const VoxelIndex& i) {
    return voxels[(static_cast<size_t>(i[2]) * static_cast<size_t>(side[1]) +
                   static_cast<size_t>(i[1])) *
                      static_cast<size_t>(side[0]) +
                  static_cast<size_t>(i[0])];
  }
  bool holds(const VoxelIndex& i) const {
    for (size_t k = 0; k < 3; ++k) {
      if (i[k] < 0 || i[k] >= side[k]) return false;
    }
    return true;
  }
  template <class F>
  void for_each(F&& f) {
    for (VoxelIndex i{}; i[2] < side[2]; ++i[2]) {
      for (i[1] = 0; i[1] < side[1]; ++i[1]) {
        for (i[0] = 0; i[0] < side[0]; ++i[0]) f(i);
      }
    }
  }
};

/// Squared distance from a point to a triangle's nearest point along each axis; whether they meet
/// is decided by polygon clipping (Sutherland & Hodgman), independent of separating axes.
bool meets_by_clipping(std::array<Vec3, 3> corners, double half) {
  std::vector<Vec3> polygon(corners.begin(), corners.end());
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      std::vector<Vec3> kept;
      for (size_t i = 0; i < polygon.size(); ++i) {
        const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double ha = sign * a[axis] - half, hb = sign * b[axis] - half;
        if (ha <= 0) kept.push_back(a);
        if ((ha < 0 && hb > 0) || (ha > 0 && hb < 0))
          kept.push_back(a + (ha / (ha - hb)) * (b - a));
      }
      polygon = std::move(kept);
      if (polygon.empty()) return false;
    }
  }
  return true;
}

DenseMap dense_map(const TriangleMesh& mesh, const Voxmap& like, int layers) {
  DenseMap map;
  for (size_t k = 0; k < 3; ++k) map.side[k] = like.bricks[k] << kBrickBits;
  map.voxels.assign(static_cast<size_t>(map.side[0]) * static_cast<size_t>(map.side[1]) *
                        static_cast<size_t>(map.side[2]),
                    Voxel::kInterior);
  map.for_each([&](const VoxelIndex& i) {
    for (const Triangle& t : mesh.triangles) {
      std::array<Vec3, 3> seen;
      bool may = true;
      for (size_t k = 0; k < 3; ++k)
        seen[k] = (mesh.vertices[t[k]] - like.centre_of(i)) / like.size;
      for (int k = 0; k < 3; ++k) {
        may &= std::min({seen[0][k], seen[1][k], seen[2][k]}) < 0.6 &&
               std::max({seen[0][k], seen[1][k], seen[2][k]}) > -0.6;
      }
      if (may && meets_by_clipping(seen, 0.5 + 1e-6)) map.at(i) = Voxel::kSurface;
    }
  });
  std::vector<VoxelIndex> open{{0, 0, 0}};
  map.at({0, 0, 0}) = Voxel::kFree;
  while (!open.empty()) {
    const VoxelIndex i = open.back();
    open.pop_back();
    for (int k = 0; k < 6; ++k) {
      VoxelIndex next = i;
      next[static_cast<size_t>(k / 2)] += k % 2 == 0 ? 1 : -1;
      if (!map.holds(next) || map.at(next) != Voxel::kInterior) continue;
      map.at(next) = Voxel::kFree;
      open.push_back(next);
    }
  }
  const auto ring = [&] {
    map.for_each([&](const VoxelIndex& i) {
      if (map.at(i) != Voxel::kFree) return;
      for (int n = 0; n < 27; ++n) {
        const VoxelIndex next{i[0] + n % 3 - 1, i[1] + n / 3 % 3 - 1, i[2] + n / 9 - 1};
        if (map.holds(next) && map.at(next) == Voxel::kSurface) map.at(i) = Voxel::kProximity;
      }
    });
  };
  ring();
  for (int layer = 0; layer < layers; ++layer) {
    for (Voxel& v : map.voxels) {
      v = v == Voxel::kSurface ? Voxel::kInterior : v == Voxel::kProximity ? Voxel::kSurface : v;
    }
    ring();
  }
  return map;
}

void equals_definition(const Soup& soup, double size, int layers) {
  const MeshShapeData shape = build_shape(soup);
  const VoxmapData data = build_voxmap(shape.view().mesh, {size, layers});
  const Voxmap map = data.view();
  DenseMap dense = dense_map(shape.view().mesh, map, layers);
  size_t wrong = 0;
  dense.for_each([&](const VoxelIndex& i) { wrong += map.at(i) != dense.at(i); });
  CAPTURE(size, layers, dense.voxels.size());
  CHECK(wrong == 0);
}

}  // namespace

TEST_CASE("voxmap: every voxel is what the definition says", "[contact]") {
  const int layers = GENERATE(0, 1, 2);
  equals_definition(make_box({0.1, 0.05, 0.03}), 4.1e-3, layers);
  equals_definition(make_icosphere(0.05, 2), kSlowdown > 1 ? 9e-3 : 4e-3, layers);
  // a room: outside is inside
  Soup hollow = make_icosphere(0.05, 1);
  append(hollow, turned_inside_out(make_icosphere(0.03, 1)));
  equals_definition(hollow, 7e-3, layers);
}

TEST_CASE("voxmap: the force begins one voxel before surfaces can touch", "[contact][trap]") {
  // two layers: everywhere on the mesh at least one whole voxel of interior lies outwards
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 3));
  const double size = 2e-3;
  const VoxmapData data = build_voxmap(shape.view().mesh, {size, 2});
  Random random(2);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 p = random.on_surface(shape.view().mesh);
    const Vec3 out = normalized(p);
    REQUIRE(data.view().at(data.view().index_of(p)) == Voxel::kInterior);
    REQUIRE(data.view().at(data.view().index_of(p + 0.99 * size * out)) != Voxel::kFree);
    REQUIRE(data.view().at(data.view().index_of(p + 8 * size * out)) == Voxel::kFree);
  }
}

TEST_CASE("voxmap: beyond the map everything is free", "[contact]") {
  const MeshShapeData shape = build_shape(make_box({0.1, 0.1, 0.1}));
  const VoxmapData data = build_voxmap(shape.view().mesh, {5e-3, 2});
  CHECK(data.view().at(VoxelIndex{-1, 5, 5}) == Voxel::kFree);
  CHECK(data.view().at(VoxelIndex{5, 5, 1 << 20}) == Voxel::kFree);
  CHECK(data.view().at(data.view().index_of({5, 5, 5})) == Voxel::kFree);
  CHECK(data.view().at(data.view().index_of({0, 0, 0})) == Voxel::kInterior);
  CHECK(build_voxmap({}, {}).data.empty());
  CHECK(build_voxmap(shape.view().mesh, {1e-6, 2}).data.empty());
}

TEST_CASE("voxmap: memory grows with the surface, not the volume", "[contact]") {
  if (kSlowdown > 1) return;
  const MeshShapeData shape = build_shape(make_icosphere(0.05, 4));
  const size_t coarse = build_voxmap(shape.view().mesh, {0.1 / 64, 2}).data.size();
  const size_t fine = build_voxmap(shape.view().mesh, {0.1 / 256, 2}).data.size();
  CHECK(fine < 20 * coarse);  // 16 for a surface, 64 for a volume
}
