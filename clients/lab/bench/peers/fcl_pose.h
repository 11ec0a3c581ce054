// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#ifdef HAPTICD_FCL
#include <fcl/common/types.h>

#include "proto/math/pose.h"

namespace haptic {

inline fcl::Transform3d fcl_pose(const Pose& X) {
  fcl::Transform3d T = fcl::Transform3d::Identity();
  T.linear() = fcl::Quaterniond(X.q.w, X.q.x, X.q.y, X.q.z).toRotationMatrix();
  T.translation() = fcl::Vector3d(X.p.x, X.p.y, X.p.z);
  return T;
}

}  // namespace haptic
#endif
