// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/baked/mesh_shape.h"

namespace haptic {

/// How the simulated hand strokes a mesh; the keys of [device.hand.intent], in O and metres.
struct MeshStrokes {
  Vec3 centre_O;       // of the ball around which it strokes
  double hover = 0;    // radius between strokes [m]
  double press = 0;    // radius to which a stroke reaches in [m]
  double angle = 0.7;  // of the arc [rad]
  Vec3 direction_O;    // where every stroke begins; zero: anew for each
  double share = 0;    // of the time in contact that is expected

  /// Time of one stroke in which the hand stays slow enough [s].
  double time() const;
};

/// Strokes from all sides around the middle of the mesh, where that touches about half of the time.
/// Else (a ring, a plate, a sheet) strokes on the place of the surface that is best for it: one
/// that nothing hides along its normal, and around which there is surface.
MeshStrokes choose_strokes(const MeshShape& shape);

}  // namespace haptic
