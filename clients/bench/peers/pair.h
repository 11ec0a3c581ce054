// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/math/pose.h"

namespace haptic {

/// Another library that is asked about two meshes, the tool at X_OT in the object.
class PairPeer {
 public:
  virtual ~PairPeer() = default;
  virtual bool collides(const Pose& X_OT) = 0;
  /// Between the surfaces; none is below 0 [m].
  virtual double distance(const Pose& X_OT) = 0;
};

/// FCL with trees of its best kind for meshes (OBBRSS); empty where this was built without it.
std::unique_ptr<PairPeer> make_fcl_peer(const TriangleMesh& object, const TriangleMesh& tool);

}  // namespace haptic
