// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "proto/math/pose.h"

namespace haptic {

/// A box for the peer; mass 0: it stands still.
struct PeerBox {
  Vec3 extent;  // [m]
  Pose X_WO;
  double mass = 0;  // [kg]
  double friction = 0;
};

/// Another library's world of boxes, as it comes, with the number of iterations of its solver.
class BodiesPeer {
 public:
  virtual ~BodiesPeer() = default;
  virtual void push(size_t box, const Vec3& impulse_W) = 0;  // at the centre [N·s]
  virtual void step(double dt) = 0;
};

/// Bullet in double precision, bodies that do not sleep; null where it is not installed.
std::unique_ptr<BodiesPeer> make_bullet_bodies(const std::vector<PeerBox>& boxes,
                                               const Vec3& gravity_W, int iterations);

}  // namespace haptic
