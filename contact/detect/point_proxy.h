// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "contact/query/closest_point.h"
#include "contact/shape/mesh_shape.h"
#include "proto/wire.h"

namespace haptic {

/// The objects at this instant, for a point detector.
struct PointScene {
  std::span<const MeshShape> shapes;
  std::array<Pose, kMaxObjects> X_WO;
  double epsilon = 1e-7;  // how far the verified proxy keeps off every surface [m]
};

/// What survives between two contact steps.
struct PointProxy {
  Vec3 g_W;  // verified position: outside every closed object
  bool seeded = false;
  std::array<Pose, kMaxObjects> X_WO;  // object poses at which g was verified
};

/// A facet that carries the proxy.
struct ProxyPlane {
  uint32_t object = 0;
  uint32_t triangle = 0;
};

struct ProxyMove {
  std::array<ProxyPlane, 3> active{};
  uint32_t n_active = 0;
  double free_fraction = 1;  // of the way from the old proxy to the tool
  uint32_t flags = 0;        // ContactFlag
};

/// Places the proxy at p_W, or, where p_W is inside a closed object, at the nearest surface point
/// found, epsilon outside. Sets kContactReseeded when it had to move, kContactNoFreePose when no
/// free pose was found (then the proxy is not seeded).
uint32_t seed_proxy(const PointScene& scene, const Vec3& p_W, PointProxy& proxy);

/// One god-object update: carries the proxy with objects that ran into it, then slides it towards
/// the tool at p_W: sweep the segment; at a hit stop epsilon in front of the facet and take its
/// plane; the next goal is the point nearest to p_W on the planes; repeat until nothing is gained.
/// Every leg is swept, so the proxy never passes a front face, in wedges and on thin plates too.
/// Sources: Zilles & Salisbury 1995; the loop over subgoals is Ruspini et al. 1997 with r = 0.
/// Deviation: planes are dropped by multiplier sign, and convergence is reached within the step
/// (the paper needs two ticks to cross a convex edge).
ProxyMove move_proxy(const PointScene& scene, const Vec3& p_W, PointProxy& proxy);

}  // namespace haptic
