// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/materials.h"
#include "servo/solve/point/friction.h"
#include "servo/solve/point/point_proxy.h"

namespace haptic {

/// An object that the proxy touches.
struct TouchedObject {
  uint32_t object = 0;
  Vec3 point_O;
};

/// The state from tick to tick.
struct VirtualProxyState {
  FrictionState friction;
  Vec3 held_back_W;                      // by friction
  std::array<TouchedObject, 3> touched;  // in the last tick
  int n_touched = 0;
};

struct VirtualProxyTick {
  double stiffness = 0;  // of the coupling [N/m]
  double dt = 1e-3;      // [s]
};

/// The virtual proxy of Ruspini, Kolarov, Khatib 1997 for this tick: the nearest place to the tool
/// on the planes (solve_point_proxy), moved along them by force shading and texture (shaded_proxy,
/// steepest_gradient), held back by friction (hold_by_friction), and brought nearer to the tool by
/// the material's share s_s of the stiffness: proxy' = tool + s_s (proxy − tool), so the effective
/// stiffness is exactly s_s k. Where several planes push, their materials are averaged, weighted by
/// the pushes.
PointProxySolution solve_virtual_proxy(const Materials& materials, VirtualProxyState& state,
                                       const ProxyQuestion& question, const VirtualProxyTick& tick);

}  // namespace haptic
