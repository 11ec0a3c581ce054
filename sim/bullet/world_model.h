// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/config/joint_config.h"
#include "proto/math/mat3.h"
#include "proto/math/pose.h"

namespace haptic {

/// Mass of a body in the frame of its object.
struct BodyMass {
  double mass = 0;  // [kg]; 0: the object stands still or follows its script
  Vec3 centre_O;
  Mat3 inertia_O;  // about the centre [kg·m²]
};

/// What an object is to others: a box or ball that fills the bounding box of its mesh, convex
/// pieces, or, of an object without mass, the triangles.
enum class CollisionShape : uint32_t { kBox, kBall, kPieces, kTriangles };

struct WorldObject {
  Pose X_WO;
  BodyMass mass;
  CollisionShape shape = CollisionShape::kTriangles;
  TriangleMesh mesh;                          // in O; must outlive the world
  std::vector<std::span<const Vec3>> pieces;  // vertices of each convex piece, in O
  double friction = 0;                        // μ; of two objects the geometric mean counts
  double restitution = 0;                     // likewise
  bool never_moves = false;                   // no mass and no script
};

struct WorldModel {
  std::vector<WorldObject> objects;
  std::vector<JointConfig> joints;
  Vec3 gravity_W;  // [m/s²]
};

}  // namespace haptic
