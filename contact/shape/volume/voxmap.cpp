// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/volume/voxmap.h"

#include <algorithm>
#include <cmath>

#include "contact/shape/mesh/box.h"
#include "contact/shape/tree/triangle_cube.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kSlack = 1e-6;  // voxels by which the triangle–box test is widened
constexpr uint32_t kAllFree = 0, kAllInterior = 1;  // bricks

constexpr std::array<VoxelIndex, 6> kFaces{
    {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

/// Each place that is written to gets its own brick.
void set_voxel(VoxmapData& map, const VoxelIndex& i, Voxel value) {
  HAPTIC_ASSERT(map.holds(i));
  uint32_t& brick = map.index[map.place_of(i)];
  if (brick == kAllFree || brick == kAllInterior) {
    map.data.push_back(map.data[brick]);
    brick = static_cast<uint32_t>(map.data.size() - 1);
  }
  map.data[brick].set(voxel_in_brick(i), value);
}

/// Marks every voxel that the triangle meets; appends the new ones.
void scan_triangle(const Corners& corners, VoxmapData& map, std::vector<VoxelIndex>& surface) {
  const Vec3 slack = kSlack * Vec3{1, 1, 1};
  const Box box = box_around(corners);
  const Vec3 low = box.lower - slack, high = box.upper + slack;
  const auto cell = [](double x) { return static_cast<int32_t>(std::floor(x)); };
  VoxelIndex i;
  for (i[2] = cell(low.z); i[2] <= cell(high.z); ++i[2]) {
    for (i[1] = cell(low.y); i[1] <= cell(high.y); ++i[1]) {
      for (i[0] = cell(low.x); i[0] <= cell(high.x); ++i[0]) {
        if (map.at(i) == Voxel::kSurface) continue;
        const Vec3 centre{i[0] + 0.5, i[1] + 0.5, i[2] + 0.5};
        const Corners seen{corners[0] - centre, corners[1] - centre, corners[2] - centre};
        if (!triangle_meets_cube(seen, 0.5 + kSlack)) continue;
        set_voxel(map, i, Voxel::kSurface);
        surface.push_back(i);
      }
    }
  }
}

std::vector<VoxelIndex> scan_surface(const TriangleMesh& mesh, VoxmapData& map) {
  std::vector<VoxelIndex> surface;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Corners corners = corners_of(mesh, t);
    for (Vec3& p : corners) p = (p - map.lower_O) / map.size;
    scan_triangle(corners, map, surface);
  }
  return surface;
}

/// Flood fill from the corner of the map: bricks without surface as a whole, the others voxel by
/// voxel. What it does not reach becomes interior.
class Flood {
 public:
  explicit Flood(VoxmapData& map)
      : map_(map), reached_bricks_(map.index.size()), reached_(map.data.size()) {}

  void run() {
    reach({0, 0, 0});
    while (!open_.empty()) {
      const VoxelIndex i = open_.back();
      open_.pop_back();
      if (map_.index[map_.place_of(i)] == kAllFree) {
        cross_brick(i);
        continue;
      }
      for (const VoxelIndex& step : kFaces) reach({i[0] + step[0], i[1] + step[1], i[2] + step[2]});
    }
    fill();
  }

 private:
  void reach(const VoxelIndex& i) {
    if (!map_.holds(i)) return;
    const size_t place = map_.place_of(i);
    const uint32_t brick = map_.index[place];
    if (brick == kAllFree) {
      if (reached_bricks_[place]) return;
      reached_bricks_[place] = true;
      open_.push_back(i);
      return;
    }
    const uint32_t voxel = voxel_in_brick(i);
    if (map_.data[brick].at(voxel) != Voxel::kFree) return;
    uint32_t& word = reached_[brick].words[voxel / kVoxelsAWord];
    const uint32_t bit = 1u << 2 * (voxel % kVoxelsAWord);
    if ((word & bit) != 0) return;
    word |= bit;
    open_.push_back(i);
  }

  /// An empty brick is crossed at once, to the bricks around it.
  void cross_brick(const VoxelIndex& i) {
    const VoxelIndex corner{i[0] & -kBrickSide, i[1] & -kBrickSide, i[2] & -kBrickSide};
    for (size_t axis = 0; axis < 3; ++axis) {
      for (const int beyond : {-1, kBrickSide}) {
        VoxelIndex next = corner;
        next[axis] += beyond;
        if (!map_.holds(next)) continue;
        if (map_.index[map_.place_of(next)] == kAllFree) {
          reach(next);
        } else {
          reach_side(next, axis);
        }
      }
    }
  }

  /// Reaches the 64 voxels of a side of a brick, from `first` on, normal to an axis.
  void reach_side(const VoxelIndex& first, size_t axis) {
    const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int a = 0; a < kBrickSide; ++a) {
      for (int b = 0; b < kBrickSide; ++b) {
        VoxelIndex i = first;
        i[u] += a;
        i[v] += b;
        reach(i);
      }
    }
  }

  void fill() {
    for (size_t place = 0; place < map_.index.size(); ++place) {
      uint32_t& brick = map_.index[place];
      if (brick == kAllFree && !reached_bricks_[place]) brick = kAllInterior;
      if (brick == kAllFree || brick == kAllInterior) continue;
      VoxelBrick& voxels = map_.data[brick];
      for (size_t w = 0; w < voxels.words.size(); ++w) {
        // free voxels are 00, reached ones are marked 01
        const uint32_t taken = voxels.words[w] | voxels.words[w] >> 1;
        voxels.words[w] |= ~taken & 0x55555555u & ~reached_[brick].words[w];
      }
    }
  }

  VoxmapData& map_;
  std::vector<bool> reached_bricks_;
  std::vector<VoxelBrick> reached_;
  std::vector<VoxelIndex> open_;
};

/// Turns the free neighbours of these voxels into proximity.
std::vector<VoxelIndex> add_ring(const std::vector<VoxelIndex>& surface, VoxmapData& map) {
  std::vector<VoxelIndex> ring;
  for (const VoxelIndex& i : surface) {
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          const VoxelIndex next{i[0] + x, i[1] + y, i[2] + z};
          if (map.at(next) != Voxel::kFree) continue;
          set_voxel(map, next, Voxel::kProximity);
          ring.push_back(next);
        }
      }
    }
  }
  return ring;
}

}  // namespace

VoxmapData build_voxmap(const TriangleMesh& mesh, const VoxmapOptions& options) {
  HAPTIC_ASSERT(options.offset_layers >= 0);
  VoxmapData map;
  if (mesh.triangles.empty() || !(options.size > 0)) return map;
  const Vec3 side = (mesh.upper - mesh.lower) / options.size;
  if (!(longest_of(side) <= kMostVoxels)) return map;
  map.size = options.size;
  map.voxels_per_metre = 1 / options.size;
  // room for the offset, a ring around it, and free voxels for the flood fill
  const int margin = options.offset_layers + 3;
  map.lower_O = mesh.lower - margin * options.size * Vec3{1, 1, 1};
  for (size_t k = 0; k < 3; ++k) {
    const int voxels = static_cast<int>(std::ceil(side[static_cast<int>(k)])) + 2 * margin;
    map.bricks[k] = (voxels + kBrickSide - 1) >> kBrickBits;
  }
  map.data.resize(2);
  map.data[kAllInterior].words.fill(0x55555555u);
  map.index.assign(static_cast<size_t>(map.bricks[0]) * static_cast<size_t>(map.bricks[1]) *
                       static_cast<size_t>(map.bricks[2]),
                   kAllFree);
  std::vector<VoxelIndex> surface = scan_surface(mesh, map);
  Flood(map).run();
  std::vector<VoxelIndex> ring = add_ring(surface, map);
  for (int layer = 0; layer < options.offset_layers; ++layer) {
    for (const VoxelIndex& i : surface) set_voxel(map, i, Voxel::kInterior);
    for (const VoxelIndex& i : ring) set_voxel(map, i, Voxel::kSurface);
    surface = std::move(ring);
    ring = add_ring(surface, map);
  }
  return map;
}

}  // namespace haptic
