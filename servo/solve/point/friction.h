// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/point/point_proxy.h"

namespace haptic {

/// Where the proxy stuck, in the frame of the object that it touches.
struct FrictionState {
  bool holds = false;   // there is an anchor
  bool slides = false;  // μ_d is in force
  uint32_t object = 0;
  Vec3 anchor_O;
};

struct FrictionLaw {
  double static_ratio = 0;   // μ_s
  double dynamic_ratio = 0;  // μ_d
  double viscous = 0;        // b [N·s/m]
  double stiffness = 0;      // k of the spring that pulls the proxy [N/m]
  double dt = 1e-3;          // [s]
};

/// Coulomb friction of the massless proxy: where it stays between its anchor and the frictionless
/// place foot_W. With f_n = k |foot − tool| and f_t = k |anchor − foot| along the surface: it
/// sticks at the anchor while f_t ≤ μ_s f_n; then it slides to the edge of the cone, f_t = μ_d f_n,
/// or with b > 0 towards it at most at ẋ = (f_t − μ_d f_n)/b. It sticks again when f_t falls below
/// 0.6 μ_d f_n (hysteresis as in CHAI3D). Viscous friction alone (μ = 0) creeps too. Source:
/// Ruspini, Kolarov, Khatib 1997. The anchor is kept in the frame of `object`, the one that pushes
/// most.
Vec3 hold_by_friction(const FrictionLaw& law, FrictionState& state, const Vec3& tool_W,
                      const Vec3& foot_W, uint32_t object, const Pose& X_WO);

}  // namespace haptic
