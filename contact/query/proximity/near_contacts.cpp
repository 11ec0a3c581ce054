// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/near_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/shape/mesh/distinct.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kKindBit = 30;  // of the half of a feature's number; the index lies below

Feature feature_of(const TriangleMesh& mesh, uint32_t triangle, TrianglePart part) {
  const auto k = static_cast<size_t>(part);
  if (k < 3) return {FeatureKind::kVertex, mesh.triangles[triangle][k]};
  if (k < 6) return {FeatureKind::kEdge, mesh.triangle_edges[triangle][k - 3]};
  return {FeatureKind::kFace, triangle};
}

/// Contact of these two features, which must be apart.
NearContact contact_between(const Feature& a, const Feature& b, const TrianglePair& triangles,
                            const TriangleDistance& at) {
  HAPTIC_ASSERT(at.distance > 0);
  const Vec3 normal_A = (at.point_b - at.point_a) / at.distance;
  return {at.point_a, at.point_b, normal_A, at.distance, feature_id(a, b), triangles};
}

/// The corner of a face that is opposite this edge.
uint32_t apex_of(const TriangleMesh& mesh, uint32_t face, uint32_t edge) {
  const Triangle& edges = mesh.triangle_edges[face];
  const auto side =
      static_cast<size_t>(std::find(edges.begin(), edges.end(), edge) - edges.begin());
  HAPTIC_ASSERT(side < 3);
  return mesh.triangles[face][(side + 2) % 3];
}

}  // namespace

uint64_t feature_id(const Feature& a, const Feature& b) {
  const auto half = [](const Feature& f) {
    return static_cast<uint64_t>(f.kind) << kKindBit | uint64_t{f.index};
  };
  return half(a) << 32 | half(b);
}

FeaturePair features_of(uint64_t feature_id) {
  const auto feature = [](uint64_t half) {
    return Feature{static_cast<FeatureKind>(half >> kKindBit & 3),
                   static_cast<uint32_t>(half & ((uint64_t{1} << kKindBit) - 1))};
  };
  return {feature(feature_id >> 32), feature(feature_id)};
}

NearContact contact_of(const TriangleMesh& mesh_A, const TriangleMesh& mesh_B,
                       const TrianglePair& triangles, const TriangleDistance& at) {
  return contact_between(feature_of(mesh_A, triangles.a, at.part_a),
                         feature_of(mesh_B, triangles.b, at.part_b), triangles, at);
}

NearContacts::NearContacts(const MeshShape& shape_A, const MeshShape& shape_B)
    : shape_A_(shape_A),
      shape_B_(shape_B),
      rings_A_(rings_of(shape_A.mesh)),
      rings_B_(rings_of(shape_B.mesh)),
      size_(norm(shape_B.mesh.upper - shape_B.mesh.lower)) {
  kept_.reserve(kRoom);
}

/// Neighbours of each vertex. Both directions of each edge are added: a border edge has one
/// triangle only.
NearContacts::Rings NearContacts::rings_of(const TriangleMesh& mesh) {
  std::vector<std::array<uint32_t, 2>> ends;
  for (const Triangle& t : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) {
      ends.push_back({t[i], t[(i + 1) % 3]});
      ends.push_back({t[(i + 1) % 3], t[i]});
    }
  }
  keep_distinct(ends);
  Rings rings;
  rings.first.assign(mesh.vertices.size() + 1, 0);
  for (const auto& [from, to] : ends) {
    ++rings.first[from + 1];
    rings.neighbour.push_back(to);
  }
  for (size_t v = 0; v < mesh.vertices.size(); ++v) rings.first[v + 1] += rings.first[v];
  return rings;
}

/// Whether the feature is locally nearest to a point along the normal, and that point is in front
/// of it.
bool NearContacts::is_nearest(const Side& side, const Feature& feature, const Vec3& point,
                              const Vec3& normal, double slack) {
  // into the frame of the mesh
  const Pose* X = side.X_AM;
  const Vec3 n = X == nullptr ? normal : rotate(conjugate(X->q), normal);
  const TriangleMesh& mesh = side.mesh;
  if (dot(n, pseudo_normal(mesh, feature)) < -slack) return false;
  if (feature.kind == FeatureKind::kFace) return true;
  const Vec3 p = X == nullptr ? point : rotate(conjugate(X->q), point - X->p);
  const auto falls_back = [&](uint32_t vertex) {
    const Vec3 way = mesh.vertices[vertex] - p;
    const double along = dot(n, way);
    return along <= 0 || along * along <= slack * slack * norm_squared(way);
  };
  if (feature.kind == FeatureKind::kEdge) {
    for (const uint32_t face : mesh.edge_faces[feature.index]) {
      if (face != kNoFace && !falls_back(apex_of(mesh, face, feature.index))) return false;
    }
    return true;
  }
  const uint32_t first = side.rings.first[feature.index];
  const uint32_t last = side.rings.first[feature.index + 1];
  for (uint32_t k = first; k < last; ++k) {
    if (!falls_back(side.rings.neighbour[k])) return false;
  }
  return true;
}

void NearContacts::add(const NearPair& pair, const TriangleDistance& at, const Pose& X_AB,
                       const NearContactOptions& options) {
  const Feature a = feature_of(shape_A_.mesh, pair.triangles.a, at.part_a);
  const Feature b = feature_of(shape_B_.mesh, pair.triangles.b, at.part_b);
  const NearContact contact = contact_between(a, b, pair.triangles, at);
  const Vec3& normal_A = contact.normal_A;
  if (!is_nearest({shape_A_.mesh, rings_A_, nullptr}, a, at.point_a, normal_A,
                  options.cone_slack)) {
    return;
  }
  const Side side_B{shape_B_.mesh, rings_B_, &X_AB};
  if (!is_nearest(side_B, b, at.point_b, -normal_A, options.cone_slack)) return;
  minima_.push_back(contact);
}

/// Parallel faces: several pairs of their features may be equally near.
void NearContacts::add_all_parts(const NearPair& pair, const Pose& X_AB,
                                 const NearContactOptions& options) {
  const Corners a = corners_of(shape_A_.mesh, pair.triangles.a);
  const Corners b = corners_of(shape_B_.mesh, pair.triangles.b, X_AB);
  std::array<TriangleDistance, kTrianglePartPairs> parts;
  const size_t n = distances_of_parts(a, b, parts);
  for (size_t i = 0; i < n; ++i) {
    if (parts[i].distance > 0 && parts[i].distance <= farthest_) add(pair, parts[i], X_AB, options);
  }
}

NearContactSet NearContacts::reduce(std::span<const NearPair> pairs, const Pose& X_AB,
                                    const NearContactOptions& options) {
  NearContactSet result;
  minima_.clear();
  farthest_ = 0;
  for (const NearPair& pair : pairs) farthest_ = std::max(farthest_, pair.at.distance);
  const double parallel = -std::cos(options.cone_slack);
  for (const NearPair& pair : pairs) {
    if (!(pair.at.distance > 0)) {
      ++result.meeting;
      continue;
    }
    const Vec3& n_a = shape_A_.mesh.face_normals[pair.triangles.a];
    const Vec3 n_b = rotate(X_AB.q, shape_B_.mesh.face_normals[pair.triangles.b]);
    if (dot(n_a, n_b) <= parallel) {
      add_all_parts(pair, X_AB, options);
    } else {
      add(pair, pair.at, X_AB, options);
    }
  }
  sort_minima();
  result.minima = minima_.size();
  result.next = thin(options);
  result.contacts = kept_;
  return result;
}

/// Keeps the nearest contact of each pair of features, then sorts by distance.
void NearContacts::sort_minima() {
  std::sort(minima_.begin(), minima_.end(), [](const NearContact& p, const NearContact& q) {
    return p.feature != q.feature ? p.feature < q.feature : p.distance < q.distance;
  });
  const auto same = [](const NearContact& p, const NearContact& q) {
    return p.feature == q.feature;
  };
  minima_.erase(std::unique(minima_.begin(), minima_.end(), same), minima_.end());
  std::sort(minima_.begin(), minima_.end(), [](const NearContact& p, const NearContact& q) {
    return p.distance != q.distance ? p.distance < q.distance : p.feature < q.feature;
  });
}

/// Merges similar contacts, the nearest first; returns the distance of the first that finds no
/// room, else ∞ [m].
double NearContacts::thin(const NearContactOptions& options) {
  const double cosine = std::cos(options.normal), reach = options.place * size_;
  kept_.clear();
  for (const NearContact& c : minima_) {
    const bool stands = std::any_of(kept_.begin(), kept_.end(), [&](const NearContact& k) {
      return dot(k.normal_A, c.normal_A) >= cosine &&
             norm_squared(k.point_a - c.point_a) <= reach * reach;
    });
    if (stands) continue;
    HAPTIC_ASSERT(kept_.size() <= kRoom);
    if (kept_.size() == kRoom) return c.distance;
    kept_.push_back(c);
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace haptic
