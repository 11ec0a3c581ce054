// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/query/rigid_motion.h"
#include "contact/shape/mesh_shape.h"

namespace haptic {

/// Torus about the z axis with radii of 30 and 8 mm and bumps of 0.4 mm: around × across quads of
/// two triangles [m].
Soup make_bumpy_torus(uint32_t around, uint32_t across);

/// Two linked tori as a hand holds them: the pose of one in the other at a time [s], in contact
/// most of the time.
Pose linked_tori(double t);

/// Motions of the tool within a tick of 1 kHz from poses of linked_tori in which it is free and
/// nearer than about 2 mm: up to 1.6 mm towards or along the other, 0.1 to 2° about any axis.
std::vector<RigidMotion> torus_motions(const MeshShape& object, const MeshShape& tool, size_t n);

}  // namespace haptic
