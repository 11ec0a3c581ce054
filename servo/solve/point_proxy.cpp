// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/point_proxy.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr double kExtentFade = 0.1;  // of the extent: width of the rim over which a plane fades

struct Plane {
  HalfSpace full;  // at full weight: the exact offset
  Vec3 point_W;
  double extent = 0;
  double weight = 1;  // share of its depth that is left, by age and extent
  uint32_t object = 0;
};

using Planes = std::array<Plane, kMaxContacts>;

double sideways(const Plane& plane, const Vec3& x_W) {
  const Vec3 along_W = x_W - plane.point_W;
  return norm(along_W - dot(plane.full.normal, along_W) * plane.full.normal);
}

/// 1 within the extent, 0 beyond the rim.
double extent_weight(const Plane& plane, const Vec3& tool_W, const Vec3& proxy_W) {
  const double rim = kExtentFade * plane.extent;
  const double beyond = std::min(sideways(plane, tool_W), sideways(plane, proxy_W)) - plane.extent;
  if (beyond <= 0) return 1;
  return beyond < rim ? 1 - beyond / rim : 0;
}

/// The plane moved towards the tool until only a share w of the depth is left.
HalfSpace relax(const HalfSpace& plane, const Vec3& tool_W, double w) {
  const double depth = plane.offset - dot(plane.normal, tool_W);
  return {plane.normal, depth > 0 && w < 1 ? plane.offset - (1 - w) * depth : plane.offset};
}

/// False when a contact or the pose of its object is not finite.
bool carry_planes(const ContactSet& contacts, const std::array<Pose, kMaxObjects>& X_WO,
                  Planes& planes, size_t& n) {
  n = std::min<size_t>(contacts.n_contacts, kMaxContacts);
  for (size_t i = 0; i < n; ++i) {
    const Contact& c = contacts.contacts[i];
    if (c.object >= kMaxObjects) return false;
    const Vec3 normal_W = rotate(X_WO[c.object].q, c.normal_O);
    const Vec3 point_W = X_WO[c.object] * c.object_point_O;
    planes[i] = {{normal_W, dot(normal_W, point_W)}, point_W, c.extent, 1, c.object};
    const bool finite = is_finite(normal_W) && is_finite(point_W) && std::isfinite(c.extent) &&
                        std::isfinite(planes[i].full.offset);
    if (!finite) return false;
  }
  return true;
}

}  // namespace

PointProxySolution solve_point_proxy(const ContactSet& contacts,
                                     const std::array<Pose, kMaxObjects>& X_WO, const Vec3& tool_W,
                                     double weight) {
  PointProxySolution out;
  out.proxy_W = tool_W;
  Planes planes;
  size_t n = 0;
  out.finite = carry_planes(contacts, X_WO, planes, n);
  if (!out.finite || weight <= 0) return out;

  std::array<HalfSpace, kMaxContacts> half_spaces;
  const std::span<const HalfSpace> view(half_spaces.data(), n);
  for (size_t i = 0; i < n; ++i) {
    planes[i].weight = weight;
    half_spaces[i] = relax(planes[i].full, tool_W, weight);
  }
  PointProjection projection = project_onto_half_spaces(tool_W, view);

  // planes that hold neither where the tool is nor where the proxy came out give way
  bool faded = false;
  for (size_t i = 0; i < n; ++i) {
    const double w = extent_weight(planes[i], tool_W, projection.x);
    if (w >= 1) continue;
    planes[i].weight = w * weight;
    half_spaces[i] = relax(planes[i].full, tool_W, planes[i].weight);
    faded = true;
  }
  if (faded) projection = project_onto_half_spaces(tool_W, view);

  out.converged = projection.converged;
  out.proxy_W = projection.x;
  out.n_active = projection.n_active;
  double pushes = 0, weighted = 0;
  for (size_t i = 0; i < static_cast<size_t>(projection.n_active); ++i) {
    const auto k = static_cast<size_t>(projection.active[i]);
    out.object[i] = planes[k].object;
    out.feature[i] = contacts.contacts[k].feature;
    out.push_W[i] = projection.multiplier[i] * half_spaces[k].normal;
    pushes += projection.multiplier[i];
    weighted += projection.multiplier[i] * planes[k].weight;
  }
  out.share = pushes > 0 ? weighted / pushes : 0;
  return out;
}

}  // namespace haptic
