// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle/plane_extent.h"

#include <algorithm>
#include <array>

#include "contact/query/simd/lanes.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr size_t kMaxVisited = 32;     // triangles of a walk
constexpr double kTurnCosine = 0.906;  // cos 25°: beyond, a plane is felt where there is nothing

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length2 = norm_squared(ab);
  const double t = length2 > 0 ? std::clamp(dot(p - a, ab) / length2, 0.0, 1.0) : 0.0;
  return norm(p - (a + t * ab));
}

/// Whether the face lies more below the plane with normal_O through a than above it.
bool falls_away(const TriangleMesh& mesh, uint32_t face, const Vec3& normal_O, const Vec3& a) {
  double lowest = 0, highest = 0;
  for (const uint32_t v : mesh.triangles[face]) {
    const double height = dot(normal_O, mesh.vertices[v] - a);
    lowest = std::min(lowest, height), highest = std::max(highest, height);
  }
  return -lowest > highest;
}

/// The triangles of the walk so far.
class Visited {
 public:
  explicit Visited(uint32_t first) {
    triangles_.fill(kNoFace);
    triangles_[size_++] = first;
  }
  size_t size() const { return size_; }
  uint32_t operator[](size_t i) const { return triangles_[i]; }
  void add(uint32_t triangle) {
    HAPTIC_ASSERT(size_ < kMaxVisited);
    triangles_[size_++] = triangle;
  }
  /// Four at a time: this is the hot spot.
  bool holds(uint32_t triangle) const {
    const IntLanes wanted = static_cast<int32_t>(triangle) - IntLanes{};
    IntLanes found{};
    for (size_t i = 0; i < size_; i += 4) {
      found |= load_lanes<IntLanes>(&triangles_[i]) == wanted;
    }
    return bits_of(load_lanes<ShortLanes>(&found)) != 0;
  }

 private:
  std::array<uint32_t, kMaxVisited> triangles_;
  size_t size_ = 0;
};

}  // namespace

double plane_extent(const TriangleMesh& mesh, uint32_t triangle, const Vec3& point_O) {
  HAPTIC_ASSERT(triangle < mesh.triangles.size());
  const Vec3 normal_O = mesh.face_normals[triangle];
  Visited visited(triangle);
  double extent = kMaxExtent;

  // breadth first over triangles that follow the plane
  for (size_t head = 0; head < visited.size() && extent > kMinExtent; ++head) {
    const Triangle& corners = mesh.triangles[visited[head]];
    for (size_t side = 0; side < 3; ++side) {
      const uint32_t next = neighbour_across(mesh, visited[head], side);
      if (next != kNoFace && visited.holds(next)) continue;
      const Vec3& a = mesh.vertices[corners[side]];
      const bool turns = next != kNoFace && dot(mesh.face_normals[next], normal_O) < kTurnCosine;
      if (turns && !falls_away(mesh, next, normal_O, a)) continue;
      const bool follows = next != kNoFace && !turns && visited.size() < kMaxVisited;
      // while nothing limits the plane, testing the end of the side suffices
      if (follows && extent == kMaxExtent && norm_squared(point_O - a) < kMaxExtent * kMaxExtent) {
        visited.add(next);
        continue;
      }
      const double distance =
          distance_to_segment(point_O, a, mesh.vertices[corners[(side + 1) % 3]]);
      if (distance >= extent) continue;
      if (follows) {
        visited.add(next);
      } else {
        extent = distance;
      }
    }
  }
  return std::max(extent, kMinExtent);
}

}  // namespace haptic
