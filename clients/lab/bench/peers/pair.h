// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/math/pose.h"

namespace haptic {

/// Another library's queries on two meshes, with the tool at X_OT in the object.
class PairPeer {
 public:
  virtual ~PairPeer() = default;
  virtual bool collides(const Pose& X_OT) = 0;
  /// Distance between the surfaces, never negative [m].
  virtual double distance(const Pose& X_OT) = 0;
};

/// FCL with its best bounding volumes for meshes (OBBRSS); null if built without FCL.
std::unique_ptr<PairPeer> make_fcl_peer(const TriangleMesh& object, const TriangleMesh& tool);

}  // namespace haptic
