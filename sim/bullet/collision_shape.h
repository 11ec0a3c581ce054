// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "sim/bullet/bullet.h"
#include "sim/bullet/world_model.h"

namespace haptic {

/// A shape of Bullet, with what it is made of.
struct OwnedShape {
  std::vector<std::unique_ptr<btCollisionShape>> parts;  // the last one is the whole
  std::unique_ptr<btTriangleIndexVertexArray> triangles;

  btCollisionShape* whole() const { return parts.back().get(); }
};

/// The shape in the axes of the body's centre of mass: X_OC is their pose in O.
OwnedShape make_shape(const WorldObject& object, const Pose& X_OC);

}  // namespace haptic
