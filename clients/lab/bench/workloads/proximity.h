// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "contact/query/box/rigid_motion.h"
#include "contact/shape/baked/mesh_shape.h"

namespace haptic {

/// Two meshes, one of which a hand moves at 1 kHz.
struct ProximityWork {
  std::string name;
  MeshShapeData object, tool;
  std::vector<Pose> poses;  // X_OT
};

/// Workload W3: a bumpy torus of 26,896 triangles on one of 40,000, touching most of the time.
ProximityWork torus_on_torus(size_t poses);

/// Workload W3: a bolt of 27,072 triangles screwed through a nut of 38,784 without contact, with a
/// gap of 0.01 to 0.06 mm along one flank of the whole thread.
ProximityWork bolt_through_nut(size_t poses);

/// Workload W5b: motions of these tori from a free pose 0.05 to 2 mm away: up to 1.6 mm, and 0.1
/// to 2 degrees about any axis through the tool's origin.
std::vector<RigidMotion> torus_motions(const ProximityWork& tori, size_t n);

}  // namespace haptic
