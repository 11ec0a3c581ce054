// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/peers/ccd.h"

#ifdef HAPTICD_FCL
#include <fcl/narrowphase/detail/traversal/collision/intersect.h>
#endif

namespace haptic {

#ifdef HAPTICD_FCL
std::optional<double> meeting_by_fcl(const CcdQuery& query, bool newton) {
  using Intersect = fcl::detail::Intersect<double>;
  const auto vector = [](const Vec3& v) { return fcl::Vector3d(v.x, v.y, v.z); };
  const auto& [a, b, c, d] = query.corners;
  double time = 0;
  fcl::Vector3d point;
  const bool meets =
      query.is_face ? Intersect::intersect_VF(vector(b.from), vector(c.from), vector(d.from),
                                              vector(a.from), vector(b.to), vector(c.to),
                                              vector(d.to), vector(a.to), &time, &point, newton)
                    : Intersect::intersect_EE(vector(a.from), vector(b.from), vector(c.from),
                                              vector(d.from), vector(a.to), vector(b.to),
                                              vector(c.to), vector(d.to), &time, &point, newton);
  return meets ? std::optional(time) : std::nullopt;
}
bool has_fcl_features() {
  return true;
}
#else
std::optional<double> meeting_by_fcl(const CcdQuery&, bool) {
  return std::nullopt;
}
bool has_fcl_features() {
  return false;
}
#endif

}  // namespace haptic
