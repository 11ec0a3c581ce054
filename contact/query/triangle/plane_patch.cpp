// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle/plane_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "contact/query/triangle/plane_extent.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr size_t kDirections = 8;           // every 45 degrees about the point
constexpr int kLongestWalk = 24;            // triangles of a walk
constexpr double kPatchTurnCosine = 0.906;  // cos 25°, as plane_extent has it
constexpr double kBetween = 0.92388;        // cos 22.5°, half the angle between two directions
constexpr double kBendReach = 4e-3;         // [m]; the bend is measured there: facets are shorter
constexpr double kLeastCurvature = 1e-3;    // less is rounding [1/m]
constexpr double kInward = 1e-3;  // share of the way to the middle of the triangle: a walk that
                                  // begins on a corner has no side to leave by

/// The two ends of the side that a walk crosses, left and right of it.
struct Gate {
  uint32_t left = 0, right = 0;
};

/// A straight walk along a plane.
struct Walk {
  const TriangleMesh& mesh;
  Vec3 from_O, normal_O, along_O, left_O;

  double side_of(uint32_t vertex) const { return dot(left_O, mesh.vertices[vertex] - from_O); }

  /// Where the walk crosses the side between two vertices.
  Vec3 crossing(const Gate& gate) const {
    const Vec3 &l = mesh.vertices[gate.left], &r = mesh.vertices[gate.right];
    const double at_l = side_of(gate.left), at_r = side_of(gate.right);
    const double t = at_l > at_r ? std::clamp(-at_r / (at_l - at_r), 0.0, 1.0) : 0.0;
    return r + t * (l - r);
  }
};

/// By which side the walk leaves its first triangle; false: by none.
bool first_gate(const Walk& walk, uint32_t triangle, Gate& gate, size_t& side) {
  const Triangle& corners = walk.mesh.triangles[triangle];
  for (size_t i = 0; i < 3; ++i) {
    const uint32_t from = corners[i], to = corners[(i + 1) % 3];
    // counter-clockwise: the way out crosses a side from its right end to its left end
    if (walk.side_of(from) > 0 || !(walk.side_of(to) > 0)) continue;
    gate = {to, from};
    side = i;
    return true;
  }
  return false;
}

/// The side of the next triangle that does not join the gate's two ends, on the walk's way.
size_t next_side(const Walk& walk, uint32_t triangle, Gate& gate) {
  const Triangle& corners = walk.mesh.triangles[triangle];
  uint32_t apex = corners[0];
  for (const uint32_t v : corners) {
    if (v != gate.left && v != gate.right) apex = v;
  }
  (walk.side_of(apex) > 0 ? gate.left : gate.right) = apex;
  for (size_t i = 0; i < 3; ++i) {
    if (corners[i] != gate.left && corners[i] != gate.right) return (i + 1) % 3;
  }
  return 0;
}

/// How far a walk leads, and the bend on its way.
struct Walked {
  double extent = 0, curvature = 0;
};

Walked walked(const Walk& walk, uint32_t triangle) {
  Walked result;
  Gate gate;
  size_t side = 0;
  if (!first_gate(walk, triangle, gate, side)) return result;
  bool is_measured = false;
  for (int step = 0; step < kLongestWalk; ++step) {
    const Vec3 way = walk.crossing(gate) - walk.from_O;
    result.extent = std::max(dot(walk.along_O, way), 0.0);
    if (!is_measured && result.extent > 0) {
      result.curvature = -2 * dot(walk.normal_O, way) / (result.extent * result.extent);
      is_measured = result.extent >= kBendReach;
    }
    if (result.extent >= kMaxExtent) break;
    const uint32_t next = neighbour_across(walk.mesh, triangle, side);
    if (next == kNoFace) break;
    const Gate before = gate;
    triangle = next;
    side = next_side(walk, triangle, gate);
    if (dot(walk.mesh.face_normals[triangle], walk.normal_O) >= kPatchTurnCosine) continue;
    const uint32_t apex = gate.left != before.left ? gate.left : gate.right;
    const Vec3 beyond = walk.mesh.vertices[apex] - walk.from_O - way;
    if (dot(walk.normal_O, beyond) > 0) result.extent = kMaxExtent;
    break;
  }
  return result;
}

}  // namespace

PlanePatch plane_patch(const TriangleMesh& mesh, uint32_t triangle, const Vec3& point_O,
                       const Vec3& normal_O) {
  HAPTIC_ASSERT(triangle < mesh.triangles.size());
  PlanePatch patch;
  if (!(dot(mesh.face_normals[triangle], normal_O) >= kPatchTurnCosine)) return patch;
  const Triangle& corners = mesh.triangles[triangle];
  Vec3 middle;
  for (const uint32_t v : corners) middle += mesh.vertices[v] / 3.0;
  Walk walk{mesh, point_O + kInward * (middle - point_O), normal_O, {}, {}};
  const Vec3 u =
      normalized(cross(normal_O, std::fabs(normal_O.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 v = cross(normal_O, u);
  patch.extent = kMaxExtent;
  double mean = 0, cosine = 0, sine = 0, least = 0;
  for (size_t k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kDirections;
    walk.along_O = std::cos(angle) * u + std::sin(angle) * v;
    walk.left_O = cross(normal_O, walk.along_O);
    const Walked there = walked(walk, triangle);
    patch.extent = std::min(patch.extent, kBetween * there.extent);
    least = k == 0 ? there.curvature : std::min(least, there.curvature);
    mean += there.curvature / kDirections;
    cosine += 2 * std::cos(2 * angle) * there.curvature / kDirections;
    sine += 2 * std::sin(2 * angle) * there.curvature / kDirections;
  }
  const double curvature = std::min(mean - std::hypot(cosine, sine), least);
  if (curvature > kLeastCurvature) patch.curvature = curvature;
  return patch;
}

}  // namespace haptic
