// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/volume.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <sstream>

#include "contact/bake/cache.h"
#include "contact/bake/grid.h"
#include "contact/query/point/closest_point.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr double kFarAway = 1e6;  // [m]; farther than anything in a scene

/// Distance to a mesh, signed if it is closed. Each thread keeps a witness: successive points are
/// neighbours.
class MeshDistance {
 public:
  explicit MeshDistance(const MeshShape& shape) : shape_(shape), number_(++builds) {}

  double operator()(const Vec3& p_O) const {
    // the thread's witness may be of another mesh at the same address
    thread_local uint64_t known = 0;
    thread_local ClosestWitness witness;
    if (known != number_) witness = {};
    known = number_;
    const ClosestPoint closest = closest_point(shape_, p_O, kFarAway, witness);
    return closest.inside ? -closest.distance : closest.distance;
  }

 private:
  static inline std::atomic<uint64_t> builds = 0;
  MeshShape shape_;
  uint64_t number_;
};

void refuse_finer(const BakedShape& shape, double size, double most, const char* what,
                  const char* key) {
  const double longest = shape.report.size;
  if (longest <= most * size) return;
  std::ostringstream text;
  text.precision(3);
  text << shape.report.file << ": " << std::llround(longest / size) << " " << what
       << " along its longest side are more than " << std::llround(most) << "; set " << key
       << " in [contact.voxel] to " << 1e3 * longest / most << " mm or more";
  throw MeshError(text.str());
}

void check_obstacle(const BakedShape& shape, const VoxelConfig& options) {
  refuse_finer(shape, options.size, kMostVoxels, "voxels", "size");
  if (shape.shape.mesh.closed || options.open_as_sheet != 0) return;
  throw MeshError(shape.report.file + ": not closed (" + std::to_string(shape.report.border_edges) +
                  " border edges), so it has no inside for voxels; fill its holes, or set "
                  "open_as_sheet = true in [contact.voxel] to touch it as a sheet");
}

/// Duration of some work [s].
double time_of(const std::function<void()>& work) {
  const int64_t start_ns = now_ns();
  work();
  return 1e-9 * static_cast<double>(now_ns() - start_ns);
}

/// From the cache, else baked and cached. `make` sets the times and returns the block.
BakedVolume cached_volume(uint64_t key,
                          const std::function<std::vector<std::byte>(BakedVolume&)>& make) {
  BakedVolume volume;
  CacheUse use = use_cached(
      key,
      [&](const MappedFile& file) {
        volume.content = view_volume(file.bytes, key, run_on_two_threads);
        volume.storage = file.storage;
      },
      [&] { return make(volume); });
  volume.from_cache = use.from_cache;
  volume.lines = std::move(use.lines);
  return volume;
}

DistanceFieldData make_field(const MeshShape& shape, const VoxelConfig& options,
                             const BakeProgress& progress) {
  const MeshDistance distance(shape);
  const double half_sheet = shape.mesh.closed ? 0 : 0.5 * options.size;
  return build_distance_field(
      shape.mesh.lower, shape.mesh.upper,
      [&](const Vec3& p_O) { return distance(p_O) - half_sheet; },
      {options.size, options.band, options.band + half_sheet}, run_on_two_threads,
      [&](double share) { progress("distance field", share); });
}

}  // namespace

BakedVolume bake_obstacle(const BakedShape& shape, const VoxelConfig& options,
                          const BakeProgress& progress) {
  check_obstacle(shape, options);
  std::ostringstream what;
  what << std::hexfloat << "map " << options.size << " " << options.offset_layers << " field "
       << options.field << " " << options.band;
  const BakeProgress tell = progress ? progress : [](std::string_view, double) {};
  const TriangleMesh& mesh = shape.shape.mesh;
  const uint64_t key = mesh_key(mesh, what.str());
  return cached_volume(key, [&](BakedVolume& volume) {
    VoxmapData map;
    DistanceFieldData field;
    tell("voxels", 0);
    volume.map_time = time_of([&] {
      map = build_voxmap(mesh, {options.size, static_cast<int>(options.offset_layers)});
    });
    if (options.field != 0) {
      tell("distance field", 0);
      volume.field_time = time_of([&] { field = make_field(shape.shape, options, tell); });
    }
    return write_volume({map.view(), field.view(), {}}, key);
  });
}

BakedVolume bake_tool(const BakedShape& shape, const VoxelConfig& options,
                      const BakeProgress& progress) {
  refuse_finer(shape, options.point_spacing, kMostCubes, "points", "point_spacing");
  std::ostringstream what;
  what << std::hexfloat << "shell 2 " << options.point_spacing;
  const TriangleMesh& mesh = shape.shape.mesh;
  const uint64_t key = mesh_key(mesh, what.str());
  return cached_volume(key, [&](BakedVolume& volume) {
    PointshellData shell;
    if (progress) progress("points", 0);
    volume.shell_time = time_of([&] { shell = build_pointshell(mesh, options.point_spacing); });
    return write_volume({{}, {}, shell.view()}, key);
  });
}

}  // namespace haptic
