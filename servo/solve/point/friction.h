// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/point/point_proxy.h"

namespace haptic {

/// Anchor of static friction, in the frame of the touched object.
struct FrictionState {
  bool holds = false;   // the anchor is valid
  bool slides = false;  // μ_d is in force
  uint32_t object = 0;
  Vec3 anchor_O;
};

struct FrictionLaw {
  double static_ratio = 0;   // μ_s
  double dynamic_ratio = 0;  // μ_d
  double viscous = 0;        // b [N·s/m]
  double stiffness = 0;      // k of the coupling [N/m]
  double dt = 1e-3;          // [s]
};

/// Coulomb friction of the massless proxy: its place between the anchor and the frictionless place
/// foot_W. With f_n = k |foot − tool| and f_t = k |anchor − foot| along the surface, the proxy
/// sticks at the anchor while f_t ≤ μ_s f_n. Then it slides to the edge of the cone, f_t = μ_d f_n;
/// with b > 0 at most at ẋ = (f_t − μ_d f_n)/b, which also gives viscous friction alone (μ = 0). It
/// sticks again once f_t ≤ 0.6 μ_d f_n (hysteresis as in CHAI3D). `object` is the one that pushes
/// most; the anchor is kept in its frame. Source: Ruspini, Kolarov, Khatib 1997.
Vec3 hold_by_friction(const FrictionLaw& law, FrictionState& state, const Vec3& tool_W,
                      const Vec3& foot_W, uint32_t object, const Pose& X_WO);

}  // namespace haptic
