// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "proto/math/project_point.h"
#include "proto/wire.h"

namespace haptic {

/// This tick's proxy of a 3-DoF renderer.
struct PointProxySolution {
  Vec3 proxy_W;
  int n_active = 0;
  std::array<uint32_t, 3> object{};   // owner of each active plane
  std::array<uint64_t, 3> feature{};  // and its id on that object
  std::array<Vec3, 3> push_W{};       // multiplier·normal: proxy − tool = Σ push_W
  double share = 0;  // of full depth that the active planes have left, by age and extent, 0 to 1
  bool converged = true;
  bool finite = true;  // false: a contact or the pose of its object held NaN or infinity
};

/// Nearest point to the tool on the free side of the contact planes (god-object, r = 0): the planes
/// are carried to where the objects are this tick, un-offset, so that |proxy − tool| is the exact
/// depth. A plane whose weight is below one gives way towards the tool: the contacts' age
/// (`weight`) and its own extent act in the same way, without a step. A plane holds in full while
/// the tool or the proxy is within its extent, then fades over a tenth of it (in a corner the tool
/// is far along one wall just because it is deep in the other). Source: Zilles & Salisbury 1995;
/// the solver is proto/math/project_point.h.
PointProxySolution solve_point_proxy(const ContactSet& contacts,
                                     const std::array<Pose, kMaxObjects>& X_WO, const Vec3& tool_W,
                                     double weight);

}  // namespace haptic
