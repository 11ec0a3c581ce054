// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/hapt/mesh_strokes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "contact/query/point/segment_hit.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr double kArm = 0.4;         // [m]; a hand strokes nothing larger
constexpr double kClearance = 0.01;  // between the strokes from all sides, from the mesh [m]
constexpr double kSpeed = 0.8;       // of the hand, at most [m/s]; half of the velocity limit
constexpr double kPeak = 1.875;      // peak over mean speed of a minimum-jerk motion
constexpr double kEnough = 0.42;     // expected share of strokes from all sides; a solid box has it
constexpr int kDirections = 96;      // that are tried for the strokes from all sides
constexpr int kPlaces = 160;         // of the surface that are tried, of equal area
constexpr int kAround = 8;           // ways in which a stroke at one place may slide
constexpr double kPlaceAngle = 0.5;  // of the arc at one place [rad]
constexpr double kDeepest = 8e-3;    // of the intention below the surface at one place [m]
constexpr double kHeight = 0.25;     // between strokes at one place, over that depth
// lengths of a stroke at one place that are tried, over the longest side
constexpr std::array kLengths{0.25, 0.12, 0.06, 0.03};

/// Share of a reach's time after its minimum-jerk progress has come to `s`.
double time_after(double s) {
  double low = 0, high = 1;
  for (int i = 0; i < 20; ++i) {
    const double a = 0.5 * (low + high);
    (a * a * a * (10 + a * (6 * a - 15)) < s ? low : high) = a;
  }
  return 1 - low;
}

/// Share of a reach along this direction in which it is in contact; none if it meets no surface.
double touched(const MeshShape& shape, const MeshStrokes& strokes, const Vec3& direction_O) {
  // beside its middle a flat place lies further from the centre
  const double slope = strokes.direction_O == Vec3{} ? 1 : dot(direction_O, strokes.direction_O);
  const double from = strokes.hover / slope;
  const Vec3& c = strokes.centre_O;
  const SegmentHit met = first_hit(shape, c + from * direction_O, c + strokes.press * direction_O);
  if (!met.hit) return 0;
  const double surface = from - met.t * (from - strokes.press);
  const double depth = strokes.hover - strokes.press;
  return time_after(std::max(strokes.hover - surface, 0.0) / depth);
}

/// The share of a cycle in contact: reach and lift take a sixth each, the slide a third, the way to
/// the next stroke the rest (device-io/hand/intent.h).
double share_of(double reach, double slide) {
  return (reach + slide) / 3;
}

MeshStrokes from_all_sides(const MeshShape& shape) {
  const Vec3 half = 0.5 * (shape.mesh.upper - shape.mesh.lower);
  MeshStrokes strokes;
  strokes.centre_O = 0.5 * (shape.mesh.lower + shape.mesh.upper);
  strokes.hover = std::min(norm(half) + kClearance, kArm);
  strokes.press = 0.5 * std::min({half.x, half.y, half.z, strokes.hover});
  double reach = 0, slide = 0;
  for (int i = 0; i < kDirections; ++i) {
    // a spiral of equal areas
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z);
    const double turn = kPi * (3 - std::sqrt(5.0)) * i;
    const double touching = touched(shape, strokes, {r * std::cos(turn), r * std::sin(turn), z});
    reach += touching / kDirections;
    slide += touching > 0 ? 1.0 / kDirections : 0;
  }
  strokes.share = share_of(reach, slide);
  return strokes;
}

/// Strokes of that length on the place p of the surface with the normal n.
MeshStrokes at_place(const MeshShape& shape, const Vec3& p, const Vec3& n, double length) {
  const double radius = length / kPlaceAngle, depth = std::min(0.5 * length, kDeepest);
  MeshStrokes strokes{p - radius * n, radius + kHeight * depth, radius - depth, kPlaceAngle, n};
  double reach = 0.5 * touched(shape, strokes, n), slide = 0;
  const Vec3 across = any_perpendicular(n), other = cross(n, across);
  for (int i = 0; i < kAround; ++i) {
    const double turn = 2 * kPi * i / kAround;
    const Vec3 side = std::cos(turn) * across + std::sin(turn) * other;
    for (const double part : {0.5, 1.0}) {
      const double angle = part * kPlaceAngle;
      const double touching = touched(shape, strokes, std::cos(angle) * n + std::sin(angle) * side);
      slide += touching > 0 ? 0.5 / kAround : 0;
      if (part == 1) reach += 0.5 / kAround * touching;
    }
  }
  strokes.share = share_of(reach, slide);
  return strokes;
}

/// True if a straight line from outside of the mesh, against the normal, reaches p unhindered.
bool is_open(const MeshShape& shape, const Vec3& p, const Vec3& n) {
  constexpr double kSame = 1e-6;  // of that way
  const double way = norm(shape.mesh.upper - shape.mesh.lower) + kClearance;
  const SegmentHit met = first_hit(shape, p + way * n, p - kSame * way * n);
  return met.hit && met.t > 1 - 3 * kSame;
}

/// Triangles at equal steps of the area.
std::vector<uint32_t> places_of(const TriangleMesh& mesh) {
  std::vector<double> area_until;
  double area = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    area += norm(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
    area_until.push_back(area);
  }
  std::vector<uint32_t> places;
  for (int i = 0; i < kPlaces; ++i) {
    const auto at = std::ranges::upper_bound(area_until, area * (i + 0.5) / kPlaces);
    const auto place = static_cast<uint32_t>(at - area_until.begin());
    if (place < mesh.triangles.size() && (places.empty() || places.back() != place)) {
      places.push_back(place);
    }
  }
  return places;
}

/// The best of the longest strokes that touch enough; of all where none do.
MeshStrokes at_best_place(const MeshShape& shape) {
  const TriangleMesh& mesh = shape.mesh;
  const Vec3 side = mesh.upper - mesh.lower;
  MeshStrokes best;
  for (const double length : kLengths) {
    for (const uint32_t place : places_of(mesh)) {
      const Triangle& t = mesh.triangles[place];
      const Vec3 p = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
      const Vec3& n = mesh.face_normals[place];
      if (!is_open(shape, p, n)) continue;
      const MeshStrokes strokes =
          at_place(shape, p, n, length * std::max({side.x, side.y, side.z}));
      if (strokes.share > best.share) best = strokes;
    }
    if (best.share > 0.5) break;
  }
  return best;
}

}  // namespace

double MeshStrokes::time() const {
  // a quarter of a stroke reaches in; half of one more travels, half way round at most
  const double way = direction_O == Vec3{} ? kPi : angle;
  return std::max({2.0, 4 * kPeak * (hover - press) / kSpeed, 2 * kPeak * way * hover / kSpeed});
}

MeshStrokes choose_strokes(const MeshShape& shape) {
  const MeshStrokes all_sides = from_all_sides(shape);
  // around what is larger than the arm the hand has no free place to begin at
  if (all_sides.share >= kEnough || all_sides.hover >= kArm) return all_sides;
  const MeshStrokes place = at_best_place(shape);
  return place.share > all_sides.share ? place : all_sides;
}

}  // namespace haptic
