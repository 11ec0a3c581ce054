// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "servo/solve/point/contact_planes.h"

namespace haptic {

/// One plane that pushes.
struct ProxyPush {
  uint32_t object = 0;   // its owner
  uint32_t contact = 0;  // index in the ContactSet
  uint64_t feature = 0;  // id on that object
  HalfSpace plane;       // in force
  Vec3 push_W;           // its part of proxy − tool
};

/// This tick's proxy of a 3-DoF renderer.
struct PointProxySolution {
  Vec3 proxy_W;
  int n_active = 0;
  std::array<ProxyPush, 3> pushes{};  // proxy − tool = Σ push_W
  double share = 0;  // of full depth that the active planes have left, by age and extent, 0 to 1
  bool converged = true;
  bool finite = true;  // false: a contact or the pose of its object held NaN or infinity
  Vec3 held_back_W;    // by friction: the proxy without it is proxy_W − held_back_W

  std::span<ProxyPush> active() { return {pushes.data(), static_cast<size_t>(n_active)}; }
  std::span<const ProxyPush> active() const {
    return {pushes.data(), static_cast<size_t>(n_active)};
  }
};

/// The planes in force, for solvers that go on from the solution.
struct PlanesInForce {
  std::array<HalfSpace, kMaxContacts> half_spaces;
  size_t size = 0;

  std::span<const HalfSpace> view() const { return {half_spaces.data(), size}; }
};

/// What a solver of this tick is given.
struct ProxyQuestion {
  const ContactSet& contacts;
  const std::array<Pose, kMaxObjects>& X_WO;  // now
  Vec3 tool_W;
  double weight = 1;  // of the contacts, by their age
  double radius = 0;  // of the proxy [m]
  Vec3 held_back_W;   // how far friction held the proxy from the tool's foot in the last tick
};

/// Nearest place of the tool's centre on the free side of the contact planes (god-object: r = 0):
/// the planes are carried to where the objects are this tick, un-offset but for the radius, so that
/// |proxy − tool| is the exact depth. A plane whose weight is below one gives way towards the tool:
/// the contacts' age and its own extent act in the same way, without a step. A plane holds in full
/// while the tool, the proxy or the place where friction held it is within its extent, then fades
/// over a tenth of it (in a corner the tool is far along one wall just because it is deep in the
/// other). Source: Zilles & Salisbury 1995; the solver is proto/math/project_point.h.
PointProxySolution solve_point_proxy(const ProxyQuestion& question, PlanesInForce& planes);

/// The same, for a point without friction.
PointProxySolution solve_point_proxy(const ContactSet& contacts,
                                     const std::array<Pose, kMaxObjects>& X_WO, const Vec3& tool_W,
                                     double weight);

}  // namespace haptic
