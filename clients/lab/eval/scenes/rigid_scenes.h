// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "clients/lab/support/shaking_hand.h"
#include "contact/shape/baked/mesh_shape.h"

namespace haptic {

/// A tool that never enters an object, and the hand that shakes it there; O coincides with W.
struct RigidScene {
  std::string name;
  MeshShape object, tool;
  std::shared_ptr<const void> storage;  // owns both
  Pose home;                            // X_OT, free
  Shaking shaking;                      // around home
};

/// Builds a scene from meshes that need no repair.
RigidScene rigid_scene(std::string name, Soup object, Soup tool);

/// A box of 20 mm on a block whose upper face is z = 0.
RigidScene box_on_plate();

/// A peg of 20 mm in its hole; `clearance` between the radii [m].
RigidScene peg_in_hole(double clearance);

/// Two scans of 75,408 triangles, 0.1 m large; empty if the folder has none. Throws MeshError.
std::optional<RigidScene> bunny_on_bunny(const std::string& meshes);

}  // namespace haptic
