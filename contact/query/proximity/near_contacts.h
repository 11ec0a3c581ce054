// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "contact/query/proximity/near_pairs.h"
#include "contact/query/triangle/closest_on_triangle.h"

namespace haptic {

/// Where two surfaces are locally nearest.
struct NearContact {
  Vec3 point_a, point_b;   // in A
  Vec3 normal_A;           // unit, from A to B
  double distance = 0;     // [m]
  uint64_t feature = 0;    // of both meshes: the same contact keeps it from pose to pose
  TrianglePair triangles;  // one of those that share it
};

/// The features of both meshes in one number: kind and index of A's in the upper half.
uint64_t feature_id(const Feature& a, const Feature& b);

/// Two triangles as one, where they are nearest: they must be apart.
NearContact contact_of(const TriangleMesh& mesh_A, const TriangleMesh& mesh_B,
                       const TrianglePair& triangles, const TriangleDistance& at);

struct NearContactOptions {
  double cone_slack = 1e-3;            // outside a normal cone by that still counts [rad]
  double normal = 0.0872664625997165;  // contacts whose normals differ by less [rad], and
  double place = 0.02;                 // whose places do, of the size of B, stand for each other
};

/// Few contacts out of many near pairs.
struct NearContactSet {
  std::span<const NearContact> contacts;  // nearest first
  size_t minima = 0;                      // before they were thinned
  size_t meeting = 0;                     // pairs at distance 0: they have no normal, and are left
  double next = 0;  // distance of the nearest that found no room, else ∞ [m]
};

/// Local minima of the distance between two surfaces, thinned. A pair of triangles gives one where
/// the way between its closest points lies in the normal cones of what carries them (no neighbour
/// is nearer) and outside both surfaces; faces that are parallel within the slack give all pairs
/// of corners, sides and faces that qualify. Triangles that share what carries it give one
/// contact. From the nearest on, contacts are kept where none is kept that stands for them; at most
/// kRoom.
/// What is lost: where the kept ones hold against a motion that turns by θ and moves the point by
/// δ, one that they stand for is passed by no more than θ · place + normal · |δ|; one for want of
/// room by |δ| − next. Work space grows until it has held the most pairs.
class NearContacts {
 public:
  static constexpr size_t kRoom = 64;

  /// Views of both shapes must outlive it.
  NearContacts(const MeshShape& shape_A, const MeshShape& shape_B);

  /// `pairs` near at X_AB. The result holds until the next call.
  NearContactSet reduce(std::span<const NearPair> pairs, const Pose& X_AB,
                        const NearContactOptions& options = {});

 private:
  /// Corners at the other ends of the edges around each vertex.
  struct Rings {
    std::vector<uint32_t> first, neighbour;
  };
  /// A mesh at its pose in A.
  struct Side {
    const TriangleMesh& mesh;
    const Rings& rings;
    const Pose* X_AM;  // none: A itself
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
