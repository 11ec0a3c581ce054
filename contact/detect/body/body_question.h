// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/shape/baked/mesh_shape.h"
#include "proto/wire/per_object.h"

namespace haptic {

/// What a detector of a tool that may enter objects is asked in a step.
struct BodyQuestion {
  Pose X_WT;  // of the tool, or its proxy
  Twist V_WT;
  PerObject<Pose> X_WO;
  PerObject<Twist> V_WO;
  double reach = 1e-3;  // what is nearer than this is reported [m]

  Pose X_OT(uint32_t object) const { return inverse(X_WO[object]) * X_WT; }
};

/// The meshes of tool and objects.
struct BodyMeshes {
  std::span<const MeshShape> objects;
  const MeshShape& tool;
};

}  // namespace haptic
