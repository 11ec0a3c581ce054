// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/bullet/collision_shape.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

// Bullet keeps shapes of this thickness between what it calls touching. Its own, 40 mm, is more
// than our objects; 0.5 mm within a box of 20 mm let ten of them stand (prototype of the world).
constexpr double kBoxMargin = 0.5e-3;  // inside a box; at most a tenth of its shortest side [m]
// outside of pieces and triangles: no more than a tenth of the clearance of our tightest fit
constexpr double kSurfaceMargin = 10e-6;  // [m]

template <typename Shape, typename... Arguments>
Shape& add(OwnedShape& owned, Arguments&&... arguments) {
  auto made = std::make_unique<Shape>(std::forward<Arguments>(arguments)...);
  Shape& shape = *made;
  owned.parts.push_back(std::move(made));
  return shape;
}

/// Puts the last part at a pose of the whole; as it is where that is the whole's own.
void put_at(OwnedShape& owned, const Pose& X_CO) {
  if (X_CO == Pose{}) return;
  btCollisionShape* const part = owned.whole();
  add<btCompoundShape>(owned, false).addChildShape(to_bullet(X_CO), part);
}

void make_pieces(OwnedShape& owned, const WorldObject& object, const Pose& X_CO) {
  std::vector<btCollisionShape*> hulls;
  for (const std::span<const Vec3> vertices : object.pieces) {
    auto& hull = add<btConvexHullShape>(owned);
    for (const Vec3& p_O : vertices) hull.addPoint(to_bullet(X_CO * p_O), false);
    // the bounding box is made with the margin: with Bullet's own all pieces of a pair would
    // overlap
    hull.setMargin(kSurfaceMargin);
    hull.recalcLocalAabb();
    hulls.push_back(&hull);
  }
  if (hulls.size() == 1) return;
  auto& whole = add<btCompoundShape>(owned, true);
  for (btCollisionShape* const hull : hulls) {
    whole.addChildShape(btTransform::getIdentity(), hull);
  }
}

void make_triangles(OwnedShape& owned, const TriangleMesh& mesh) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Triangle) == 3 * sizeof(int));
  btIndexedMesh indexed;
  indexed.m_numTriangles = static_cast<int>(mesh.triangles.size());
  indexed.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(mesh.triangles.data());
  indexed.m_triangleIndexStride = sizeof(Triangle);
  indexed.m_numVertices = static_cast<int>(mesh.vertices.size());
  indexed.m_vertexBase = reinterpret_cast<const unsigned char*>(mesh.vertices.data());
  indexed.m_vertexStride = sizeof(Vec3);
  indexed.m_vertexType = PHY_DOUBLE;
  owned.triangles = std::make_unique<btTriangleIndexVertexArray>();
  owned.triangles->addIndexedMesh(indexed, PHY_INTEGER);
  add<btBvhTriangleMeshShape>(owned, owned.triangles.get(), true).setMargin(kSurfaceMargin);
}

}  // namespace

OwnedShape make_shape(const WorldObject& object, const Pose& X_OC) {
  const Vec3 half = 0.5 * (object.mesh.upper - object.mesh.lower);
  const Vec3 middle_O = 0.5 * (object.mesh.upper + object.mesh.lower);
  const Pose X_CO = inverse(X_OC);
  OwnedShape owned;
  switch (object.shape) {
    case CollisionShape::kBox: {
      const double shortest = 2 * std::min({half.x, half.y, half.z});
      add<btBoxShape>(owned, to_bullet(half)).setMargin(std::min(kBoxMargin, 0.1 * shortest));
      put_at(owned, X_CO * Pose{middle_O, {}});
      break;
    }
    case CollisionShape::kBall:
      add<btSphereShape>(owned, half.x);
      put_at(owned, {X_CO * middle_O, {}});
      break;
    case CollisionShape::kPieces:
      make_pieces(owned, object, X_CO);
      break;
    case CollisionShape::kTriangles:
      HAPTIC_ASSERT(object.mass.mass == 0);
      make_triangles(owned, object.mesh);
      put_at(owned, X_CO);
      break;
  }
  return owned;
}

}  // namespace haptic
