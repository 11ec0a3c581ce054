// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/piece_contact.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "contact/shape/convex/convex_polygon.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr uint32_t kFaceCorners = 32;              // of a face with more, every n-th counts
constexpr size_t kMostCorners = 2 * kFaceCorners;  // each wall of one adds a corner to the other
constexpr double kNoWay = 1e-6;      // |Σ δ n| / Σ δ below which the ways out cancel
constexpr double kSamePlace = 1e-9;  // depth of the deepest corner below that of the pair [m]

using Polygon = ConvexPolygon<kMostCorners>;

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
    overlap = overlap.clipped(cross(n_A, way), from, 0);
  }
  return overlap;
}

/// Scales what pushes so that its depths add up to `most` [m] at most.
void limit(std::span<PieceContact> contacts, double most) {
  double sum = 0;
  for (const PieceContact& c : contacts) sum += std::max(c.depth, 0.0);
  if (!(sum > most)) return;
  for (PieceContact& c : contacts) {
    if (!(c.depth > 0)) continue;
    c.depth *= most / sum;
    c.point_a_A = c.point_b_A + c.depth * c.normal_A;
  }
}

/// How deep a pair is, where, and along which normal it pushes or will, as piece_contacts() says;
/// the normal zero: neither.
PieceContact push_of(const PieceTouch& touch, double hulls, const Vec3& point_b_A,
                     const LocalDepth* local) {
  PieceContact push;
  push.depth = hulls;
  push.point_b_A = point_b_A;
  if (local != nullptr && local->sum > 0) {
    const double way = norm(local->way_A);
    const bool has_way = way > kNoWay * local->sum;
    push.depth = std::min(std::max(hulls, local->deepest), local->sum);
    // what hulls say that do not overlap is said of another place
    const bool is_out = !has_way || dot(touch.normal_A, local->way_A) >= 0;
    if (touch.real && hulls > 0 && is_out) {
      push.normal_A = touch.normal_A;
    } else if (has_way) {
      push.normal_A = local->way_A / way;
      push.point_b_A = local->places_A / local->sum;
    }
  } else if (touch.real && (hulls <= 0 || local == nullptr)) {
    push.normal_A = touch.normal_A;
  }
  push.point_a_A = push.point_b_A + push.depth * push.normal_A;
  return push;
}

/// The corners of the overlap of the two faces of a contact, each with its depth, less by `within`
/// [m]; returns their number.
size_t corners_of_overlap(const PieceContact& contact, const Polygon& overlap,
                          const HullFace& face_a, double within, double tolerance,
                          std::span<PieceContact, kMostOfPair> corners) {
  // the face of A as a height over the plane of the contact
  const double tilt = dot(face_a.normal, contact.normal_A);
  HAPTIC_ASSERT(tilt > 0);
  const size_t step = std::max<size_t>((overlap.n + kMostOfPair - 1) / kMostOfPair, 1);
  size_t n = 0;
  for (size_t i = 0; i < overlap.n; i += step) {
    const Vec3& p = overlap.point[i];
    const double height = (face_a.offset - dot(face_a.normal, p)) / tilt;
    const double depth = std::min(height - within, contact.depth);
    if (depth < -tolerance) continue;
    corners[n] = contact;
    corners[n].depth = depth;
    // where the faces are farther through each other than the pair is deep: as deep as the pair
    corners[n].point_a_A = p + std::max(height, depth) * contact.normal_A;
    corners[n].point_b_A = corners[n].point_a_A - depth * contact.normal_A;
    ++n;
  }
  return n;
}

}  // namespace

PieceTouch touch_of(const PieceTree& tree_a, uint32_t a, const PieceTree& tree_b, uint32_t b,
                    const Pose& X_AB, ConvexPairState& state) {
  const Hull hull_a = tree_a.hull(tree_a.pieces[a]), hull_b = tree_b.hull(tree_b.pieces[b]);
  const ConvexContact asked = convex_contact(hull_a, hull_b, X_AB, state);
  PieceTouch touch;
  touch.hulls = asked.gap;
  if (!asked.found) return touch;
  touch.normal_A = asked.normal_A;
  touch.point_a_A = asked.point_a;
  touch.point_b_B = inverse(X_AB) * asked.point_b;
  touch.face_a = face_along(hull_a, asked.normal_A);
  touch.face_b = face_along(hull_b, -rotate(conjugate(X_AB.q), asked.normal_A));
  touch.real = asked.real && touch.face_a != kNoFaceAlong && touch.face_b != kNoFaceAlong;
  return touch;
}

double depth_of(const PieceTouch& touch, const Pose& X_AB) {
  return dot(touch.normal_A, touch.point_a_A - X_AB * touch.point_b_B);
}

size_t piece_contacts(const PieceTree& tree_a, uint32_t a, const PieceTree& tree_b, uint32_t b,
                      const Pose& X_AB, const PieceTouch& touch, const LocalDepth* local,
                      const PieceContactOptions& options,
                      std::span<PieceContact, kMostOfPair> contacts) {
  const Piece &piece_a = tree_a.pieces[a], &piece_b = tree_b.pieces[b];
  const double within = local == nullptr ? piece_a.overhang + piece_b.overhang : 0;
  PieceContact contact =
      push_of(touch, depth_of(touch, X_AB) - within, X_AB * touch.point_b_B, local);
  const Vec3& n_A = contact.normal_A;
  if (n_A == Vec3{} || contact.depth < -options.tolerance) return 0;
  contact.piece_a = a;
  contact.piece_b = b;
  size_t n = 0;
  if (std::min(piece_a.radius, piece_b.radius) > options.spread) {
    const Hull hull_a = tree_a.hull(piece_a), hull_b = tree_b.hull(piece_b);
    const bool is_asked = n_A == touch.normal_A;
    const uint32_t a_along = is_asked ? touch.face_a : face_along(hull_a, n_A);
    const uint32_t b_along =
        is_asked ? touch.face_b : face_along(hull_b, -rotate(conjugate(X_AB.q), n_A));
    if (a_along != kNoFaceAlong && b_along != kNoFaceAlong) {
      const HullFace& face_a = hull_a.faces[a_along];
      const Polygon overlap =
          overlap_along(n_A, hull_a, face_a, hull_b, hull_b.faces[b_along], X_AB);
      n = corners_of_overlap(contact, overlap, face_a, within, options.tolerance, contacts);
    }
  }
  // the deepest place need not be a corner of the faces that lie best along the normal
  const bool is_there = std::any_of(contacts.begin(), contacts.begin() + n, [&](const auto& c) {
    return c.depth >= contact.depth - kSamePlace;
  });
  if (!is_there) {
    n = std::min(n, kMostOfPair - 1);
    contacts[n++] = contact;
  }
  if (local != nullptr) limit(contacts.first(n), local->sum);
  return n;
}

}  // namespace haptic
