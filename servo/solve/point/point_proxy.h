// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "proto/math/project_point.h"
#include "servo/solve/carried_contacts.h"

namespace haptic {

/// One active plane.
struct ProxyPush {
  uint32_t object = 0;   // the body that it belongs to (TickScene)
  uint32_t contact = 0;  // index in the ContactSet
  uint64_t feature = 0;  // id on that object
  HalfSpace plane;       // relaxed, as it was used
  Vec3 push_W;           // its part of proxy − tool
};

/// This tick's proxy of a 3-DoF renderer.
struct PointProxySolution {
  Vec3 proxy_W;
  int n_active = 0;
  std::array<ProxyPush, 3> pushes{};  // proxy − tool = Σ push_W
  double share = 0;  // of full depth left to the active planes, by age and extent, 0 to 1
  bool converged = true;
  bool finite = true;  // false: a contact or the pose of its object was not finite
  Vec3 held_back_W;    // by friction; without friction the proxy is at proxy_W − held_back_W

  /// Adds an active plane: that of the contact with this index, of this body, which makes proxy −
  /// tool longer by `way` [m].
  void add(const ContactSet& set, uint32_t index, uint32_t body, const HalfSpace& plane,
           double way) {
    const auto next = static_cast<size_t>(n_active++);
    pushes[next] = {body, index, set.contacts[index].feature, plane, way * plane.normal};
  }

  std::span<ProxyPush> active() { return {pushes.data(), static_cast<size_t>(n_active)}; }
  std::span<const ProxyPush> active() const {
    return {pushes.data(), static_cast<size_t>(n_active)};
  }
};

/// The planes as used, for later stages of a solver.
struct PlanesInForce {
  std::array<HalfSpace, kMaxContacts> half_spaces;
  size_t size = 0;

  std::span<const HalfSpace> view() const { return {half_spaces.data(), size}; }
};

/// Input of a point solver.
struct ProxyQuestion {
  const ContactSet& contacts;
  const TickScene& scene;
  Vec3 tool_W;
  double radius = 0;  // of the proxy [m]
  Vec3 held_back_W;   // offset by friction in the last tick, from the frictionless proxy
};

/// The plane of a contact, offset by the radius of the tool and moved towards it, so that only the
/// contact's weight is left of the depth.
HalfSpace relaxed(const CarriedContact& contact, double radius, const Vec3& tool_W);

/// Nearest place of the tool's centre on the free side of the contact planes (god-object: radius
/// 0). The planes are carried to this tick's poses of their objects and offset by the radius only,
/// so |proxy − tool| is the exact depth. A plane with weight below one is relaxed towards the tool:
/// age and extent both act this way, without a step. A plane has full weight while the tool, the
/// proxy or the place where friction held it is within its extent, then fades over a tenth of it
/// (in a corner the tool may be far along one wall only because it is deep in the other). Source:
/// Zilles & Salisbury 1995; the solver is proto/math/project_point.h.
PointProxySolution solve_point_proxy(const ProxyQuestion& question, PlanesInForce& planes);

}  // namespace haptic
