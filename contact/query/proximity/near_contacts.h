// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "contact/query/proximity/near_pairs.h"
#include "contact/query/triangle/closest_on_triangle.h"

namespace haptic {

/// A local minimum of the distance between two surfaces.
struct NearContact {
  Vec3 point_a, point_b;   // in A
  Vec3 normal_A;           // unit, from A to B
  double distance = 0;     // [m]
  uint64_t feature = 0;    // of both meshes; identifies the contact from pose to pose
  TrianglePair triangles;  // one of the pairs that share the features
};

/// The features of both meshes as one number: kind and index of A's feature in the upper half.
uint64_t feature_id(const Feature& a, const Feature& b);

/// The two features of a number made by feature_id.
struct FeaturePair {
  Feature a, b;
};
FeaturePair features_of(uint64_t feature_id);

/// The contact of two triangles at their closest points; they must be apart.
NearContact contact_of(const TriangleMesh& mesh_A, const TriangleMesh& mesh_B,
                       const TrianglePair& triangles, const TriangleDistance& at);

struct NearContactOptions {
  double cone_slack = 1e-3;            // tolerance of the normal cones [rad]
  double normal = 0.0872664625997165;  // contacts whose normals differ by less [rad] (5°), and
  double place = 0.02;                 // whose points do, relative to the size of B, are merged
};

/// The few contacts that represent many near pairs.
struct NearContactSet {
  std::span<const NearContact> contacts;  // nearest first
  size_t minima = 0;                      // local minima before merging
  size_t meeting = 0;  // pairs at distance 0: they have no normal, and are ignored
  double next = 0;     // distance of the nearest contact beyond kRoom [m]; else ∞
};

/// Local minima of the distance between two surfaces, merged. A pair of triangles contributes one
/// if the segment between its closest points lies in the normal cones of the features that carry
/// them (no neighbour is nearer) and outside both surfaces; faces parallel within the tolerance
/// contribute all qualifying pairs of corners, edges and faces. Triangles that share the features
/// give one contact. Greedy from the nearest on: a contact is kept unless a kept one represents it;
/// at most kRoom.
/// Error of merging: a motion that turns by θ and moves the point by δ, and that the kept contacts
/// allow, violates a merged one by at most θ · place + normal · |δ|, one beyond kRoom by |δ| −
/// next. Allocates until it has held the most pairs.
class NearContacts {
 public:
  static constexpr size_t kRoom = 64;

  /// The arrays that both shapes view must outlive it.
  NearContacts(const MeshShape& shape_A, const MeshShape& shape_B);

  /// `pairs`: near at X_AB. The result is valid until the next call.
  NearContactSet reduce(std::span<const NearPair> pairs, const Pose& X_AB,
                        const NearContactOptions& options = {});

 private:
  /// Neighbours of each vertex along the edges.
  struct Rings {
    std::vector<uint32_t> first, neighbour;
  };
  /// A mesh and its pose in A.
  struct Side {
    const TriangleMesh& mesh;
    const Rings& rings;
    const Pose* X_AM;  // null: A itself
  };
  static Rings rings_of(const TriangleMesh& mesh);
  static bool is_nearest(const Side& side, const Feature& feature, const Vec3& point,
                         const Vec3& normal, double slack);
  void add(const NearPair& pair, const TriangleDistance& at, const Pose& X_AB,
           const NearContactOptions& options);
  void add_all_parts(const NearPair& pair, const Pose& X_AB, const NearContactOptions& options);
  void sort_minima();
  double thin(const NearContactOptions& options);

  MeshShape shape_A_, shape_B_;
  Rings rings_A_, rings_B_;
  double size_ = 0, farthest_ = 0;
  std::vector<NearContact> minima_;
  std::vector<NearContact> kept_;
};

}  // namespace haptic
