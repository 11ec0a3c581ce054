// SPDX-License-Identifier: GPL-3.0-or-later
// A joint whose way lies across its axis, along x of J.
#include "sim/joint/joint.h"

namespace haptic {
namespace {

JointAxis rail_axis(const Joint&, const Pose& X_WJa, const Pose& X_WJb, double) {
  const std::array<Vec3, 3> axes_W{rotate(X_WJb.q, {0, 1, 0}), rotate(X_WJb.q, {0, 0, 1}),
                                   rotate(X_WJb.q, {1, 0, 0})};
  return {axes_W, X_WJb.p, {}, dot(axes_W[2], X_WJa.p - X_WJb.p)};
}

CurvePoint rail_point(const Joint&, double position) {
  return {{position, 0, 0}, {1, 0, 0}, {}};
}

}  // namespace

extern const JointPath rail_path{rail_axis, rail_point};

}  // namespace haptic
