// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/baked/volume.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr size_t kVolumeArrays = 14;      // the scalars and those of for_each_volume_array
constexpr size_t kUniformBricks = 2;      // all free and all interior, in every map
constexpr int32_t kMostBricks = 1 << 10;  // along a side: 4096 voxels and their margin

/// Scalars, as an array of one.
struct VolumeFacts {
  Vec3 map_lower, field_lower;
  double voxel = 0, cell = 0, band = 0, spacing = 0, radius = 0;
  std::array<int32_t, 3> map_bricks{}, field_bricks{};
};

/// Calls f for each array, in the order of the file.
template <class Content, class F>
void for_each_volume_array(Content& content, F&& f) {
  auto& shell = content.shell;
  f(content.map.index), f(content.map.data);
  f(content.field.index), f(content.field.middle), f(content.field.data);
  f(shell.x), f(shell.y), f(shell.z), f(shell.nx), f(shell.ny), f(shell.nz);
  f(shell.nodes), f(shell.levels);
}

VolumeFacts facts_of(const VolumeContent& c) {
  return {c.map.lower_O,   c.field.lower_O, c.map.size,   c.field.cell,  c.field.band,
          c.shell.spacing, c.shell.radius,  c.map.bricks, c.field.bricks};
}

/// Whether the number of places is that of a box of bricks of valid size.
bool is_box(const std::array<int32_t, 3>& bricks, size_t places) {
  for (const int32_t n : bricks) {
    if (n < 1 || n > kMostBricks) return false;
  }
  return places == static_cast<size_t>(bricks[0]) * static_cast<size_t>(bricks[1]) *
                       static_cast<size_t>(bricks[2]);
}

bool is_length(double x) {
  return x > 0 && std::isfinite(x);
}

void check_map(const Voxmap& map) {
  if (map.index.empty()) return require_baked(map.data.empty(), "voxels without a map");
  require_baked(is_length(map.size) && is_finite(map.lower_O) &&
                    is_box(map.bricks, map.index.size()) && map.data.size() >= kUniformBricks,
                "a broken map");
  require_baked(std::all_of(map.index.begin(), map.index.end(),
                            [&](uint32_t i) { return i < map.data.size(); }),
                "a brick of the map out of range");
}

void check_field(const DistanceField& field) {
  if (field.index.empty()) return require_baked(field.data.empty(), "distances without a field");
  require_baked(is_length(field.cell) && is_length(field.band) && is_finite(field.lower_O) &&
                    is_box(field.bricks, field.index.size()) &&
                    field.middle.size() == field.index.size(),
                "a broken field");
  require_baked(
      std::all_of(field.index.begin(), field.index.end(),
                  [&](uint32_t i) { return i == kNoFieldBrick || i < field.data.size(); }),
      "a brick of the field out of range");
}

/// Whether the points of a node exist and are no more than the cubes within one of 2^height times
/// their edge (the room of a search), and its children are the next in order.
bool is_sound(const ShellNode& node, size_t height, size_t n_points, size_t next_child) {
  const uint64_t cubes = uint64_t{1} << std::min<size_t>(3 * height, 63);
  return node.count > 0 && node.count <= cubes && node.first <= n_points &&
         node.count <= n_points - node.first && node.point < n_points && node.radius >= 0 &&
         (node.n_children == 0 || node.first_child == next_child);
}

void check_shell(const Pointshell& shell) {
  const size_t n = shell.x.size();
  require_baked(shell.y.size() == n && shell.z.size() == n && shell.nx.size() == n &&
                    shell.ny.size() == n && shell.nz.size() == n,
                "coordinates of different lengths");
  if (n == 0) return require_baked(shell.nodes.empty(), "a shell without points");
  require_baked(is_length(shell.spacing) && std::isfinite(shell.radius) &&
                    shell.levels.size() >= 2 && shell.levels[0] == 0 && shell.levels[1] == 1 &&
                    shell.levels.back() == shell.nodes.size() &&
                    std::is_sorted(shell.levels.begin(), shell.levels.end()),
                "a shell with broken levels");
  for (size_t level = 0; level + 1 < shell.levels.size(); ++level) {
    // every node is the child of exactly one: a search has room for each node once
    const size_t next = shell.levels[level + 1];
    size_t child = next;
    const size_t height = shell.levels.size() - 2 - level;  // above the points
    for (size_t i = shell.levels[level]; i < next; ++i) {
      require_baked(is_sound(shell.nodes[i], height, n, child), "a broken node of the shell");
      child += shell.nodes[i].n_children;
    }
    const bool is_last = level + 2 == shell.levels.size();
    require_baked(child == (is_last ? next : shell.levels[level + 2]),
                  "a level of the shell without parents");
  }
}

}  // namespace

std::vector<std::byte> write_volume(const VolumeContent& content, uint64_t key) {
  const VolumeFacts facts = facts_of(content);
  std::vector<std::span<const std::byte>> arrays{std::as_bytes(std::span(&facts, 1))};
  for_each_volume_array(content,
                        [&](const auto& array) { arrays.push_back(std::as_bytes(array)); });
  return write_block(BakedKind::kVolume, key, arrays);
}

VolumeContent view_volume(std::span<const std::byte> bytes, uint64_t key, const RunBoth& run_both) {
  const BakedBlock block = view_block(bytes, BakedKind::kVolume, key, kVolumeArrays);
  const auto facts = view_array<VolumeFacts>(block.arrays[0]);
  require_baked(facts.size() == 1, "an array of another type");
  VolumeContent content;
  size_t i = 1;
  for_each_volume_array(content, [&]<class T>(std::span<const T>& array) {
    array = view_array<T>(block.arrays[i++]);
  });
  const VolumeFacts& f = facts[0];
  content.map.lower_O = f.map_lower;
  content.map.size = f.voxel;
  content.map.voxels_per_metre = f.voxel > 0 ? 1 / f.voxel : 0;
  content.map.bricks = f.map_bricks;
  content.field.lower_O = f.field_lower;
  content.field.cell = f.cell;
  content.field.band = f.band;
  content.field.bricks = f.field_bricks;
  content.shell.spacing = f.spacing;
  content.shell.radius = f.radius;
  run_both([&] { check_half(block, 0); },
           [&] {
             check_half(block, 1);
             check_map(content.map);
             check_field(content.field);
             check_shell(content.shell);
           });
  return content;
}

}  // namespace haptic
