// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/piece_contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kNoBound = std::numeric_limits<double>::infinity();
constexpr uint32_t kFaceCorners = 32;              // of a face with more, every n-th counts
constexpr size_t kMostCorners = 2 * kFaceCorners;  // each wall of one adds a corner to the other
constexpr double kSamePlace = 1e-9;  // depth of the deepest corner below that of the pair [m]

/// A convex polygon.
struct Polygon {
  std::array<Vec3, kMostCorners> point;
  size_t n = 0;

  void add(const Vec3& p) {
    if (n < point.size()) point[n++] = p;
  }
};

constexpr uint32_t kNoFaceAlong = ~0u;

/// The real face whose normal is nearest to the direction, if any faces it.
uint32_t face_along(const Hull& hull, const Vec3& way) {
  uint32_t best = kNoFaceAlong;
  double most = 0;
  for (uint32_t i = 0; i < hull.faces.size(); ++i) {
    const double cosine = dot(hull.faces[i].normal, way);
    if (hull.faces[i].is_virtual != 0 || !(cosine > most)) continue;
    most = cosine;
    best = i;
  }
  return best;
}

/// The part of the polygon with wall·(p − from) ≤ 0 (Sutherland & Hodgman 1974).
Polygon clipped(const Polygon& polygon, const Vec3& wall, const Vec3& from) {
  Polygon kept;
  for (size_t i = 0; i < polygon.n; ++i) {
    const Vec3 &p = polygon.point[i], &q = polygon.point[i + 1 < polygon.n ? i + 1 : 0];
    const double at_p = dot(wall, p - from), at_q = dot(wall, q - from);
    if (at_p <= 0) kept.add(p);
    if ((at_p <= 0) != (at_q <= 0)) kept.add(p + at_p / (at_p - at_q) * (q - p));
  }
  return kept;
}

/// The corners of a face, by `place` in A.
template <class Place>
Polygon corners_of(const Hull& hull, const HullFace& face, const Place& place) {
  Polygon polygon;
  const uint32_t step = (face.n_edges + kFaceCorners - 1) / kFaceCorners;
  for (uint32_t k = 0; k < face.n_edges; k += step) {
    polygon.add(place(hull.vertices[hull.edges[face.first_edge + k].from]));
  }
  return polygon;
}

/// The overlap of two faces as seen along the normal, in the plane of B's.
Polygon overlap_along(const Vec3& n_A, const Hull& hull_a, const HullFace& face_a,
                      const Hull& hull_b, const HullFace& face_b, const Pose& X_AB) {
  Polygon overlap = corners_of(hull_b, face_b, [&](const Vec3& p_B) { return X_AB * p_B; });
  const Polygon walls = corners_of(hull_a, face_a, [](const Vec3& p_A) { return p_A; });
  for (size_t i = 0; i < walls.n && overlap.n > 0; ++i) {
    const Vec3& from = walls.point[i];
    const Vec3 way = walls.point[i + 1 < walls.n ? i + 1 : 0] - from;
    overlap = clipped(overlap, cross(way, n_A), from);
  }
  return overlap;
}

}  // namespace

PieceTouch touch_of(const PieceTree& tree_a, uint32_t a, const PieceTree& tree_b, uint32_t b,
                    const Pose& X_AB, ConvexPairState& state) {
  const Hull hull_a = tree_a.hull(tree_a.pieces[a]), hull_b = tree_b.hull(tree_b.pieces[b]);
  const ConvexContact asked = convex_contact(hull_a, hull_b, X_AB, state);
  PieceTouch touch;
  touch.hulls = asked.gap;
  if (!asked.found || !asked.real) return touch;
  const Pose X_BA = inverse(X_AB);
  touch.normal_A = asked.normal_A;
  touch.point_a_A = asked.point_a;
  touch.point_b_B = X_BA * asked.point_b;
  touch.face_a = face_along(hull_a, asked.normal_A);
  touch.face_b = face_along(hull_b, -rotate(X_BA.q, asked.normal_A));
  touch.is_contact = touch.face_a != kNoFaceAlong && touch.face_b != kNoFaceAlong;
  return touch;
}

size_t piece_contacts(const PieceTree& tree_a, uint32_t a, const PieceTree& tree_b, uint32_t b,
                      const Pose& X_AB, const PieceTouch& touch, const PieceContactOptions& options,
                      std::span<PieceContact, kMostOfPair> contacts) {
  if (!touch.is_contact) return 0;
  const Piece &piece_a = tree_a.pieces[a], &piece_b = tree_b.pieces[b];
  const Vec3& n_A = touch.normal_A;
  PieceContact contact;
  contact.normal_A = n_A;
  contact.piece_a = a;
  contact.piece_b = b;
  // the surface lies within the hull by up to its overhang: what is certain is what pushes
  const Vec3 within_a = piece_a.overhang * n_A, within_b = piece_b.overhang * n_A;
  contact.point_a_A = touch.point_a_A - within_a;
  contact.point_b_A = X_AB * touch.point_b_B + within_b;
  contact.depth = dot(n_A, contact.point_a_A - contact.point_b_A);
  if (contact.depth < -options.tolerance) return 0;
  const HullFace& face_a = tree_a.faces[piece_a.first_face + touch.face_a];
  const HullFace& face_b = tree_b.faces[piece_b.first_face + touch.face_b];
  contact.triangle_a = face_a.triangle;
  contact.triangle_b = face_b.triangle;
  contacts[0] = contact;
  if (std::min(piece_a.radius, piece_b.radius) <= options.spread) return 1;
  const Polygon overlap =
      overlap_along(n_A, tree_a.hull(piece_a), face_a, tree_b.hull(piece_b), face_b, X_AB);
  // the face of A as a height over the plane of the contact
  const double tilt = dot(face_a.normal, n_A);
  HAPTIC_ASSERT(tilt > 0);
  const size_t step = std::max<size_t>((overlap.n + kMostOfPair - 1) / kMostOfPair, 1);
  size_t n = 0;
  double deepest = -kNoBound;
  for (size_t i = 0; i < overlap.n; i += step) {
    const Vec3& p = overlap.point[i];
    const double hulls = (face_a.offset - dot(face_a.normal, p)) / tilt;
    const double depth = std::min(hulls - piece_a.overhang - piece_b.overhang, contact.depth);
    if (depth < -options.tolerance) continue;
    deepest = std::max(deepest, depth);
    contacts[n] = contact;
    contacts[n].depth = depth;
    contacts[n].point_b_A = p + within_b;
    contacts[n].point_a_A = contacts[n].point_b_A + depth * n_A;
    ++n;
  }
  // the deepest place need not be a corner of the faces that lie best along the normal
  if (n == 0 || deepest < contact.depth - kSamePlace) {
    n = std::min(n, kMostOfPair - 1);
    contacts[n++] = contact;
  }
  return n;
}

}  // namespace haptic
