// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/point/friction.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kRestick = 0.6;  // share of the dynamic cone below which it sticks again

}  // namespace

Vec3 hold_by_friction(const FrictionLaw& law, FrictionState& state, const Vec3& tool_W,
                      const Vec3& foot_W, uint32_t object, const Pose& X_WO) {
  HAPTIC_ASSERT(law.dt > 0);
  HAPTIC_ASSERT(law.static_ratio >= 0 && law.dynamic_ratio >= 0 && law.viscous >= 0);
  const Vec3 normal_W = foot_W - tool_W;
  const double depth = norm(normal_W);
  if (depth == 0 || (law.static_ratio == 0 && law.viscous == 0)) {
    state.holds = false;
    return foot_W;
  }
  // a new touch, or another object now pushes most
  if (!state.holds || state.object != object) state = {true, false, object, inverse(X_WO) * foot_W};

  Vec3 offset_W = X_WO * state.anchor_O - foot_W;
  offset_W -= (dot(offset_W, normal_W) / (depth * depth)) * normal_W;
  const double offset = norm(offset_W);
  const double cone = law.dynamic_ratio * depth;
  if (offset > law.static_ratio * depth) state.slides = true;
  if (offset <= kRestick * cone) state.slides = false;
  if (!state.slides || offset <= cone) return foot_W + offset_W;

  const double way =
      law.viscous > 0
          ? std::min(law.stiffness * (offset - cone) / law.viscous * law.dt, offset - cone)
          : offset - cone;
  const Vec3 held_W = foot_W + ((offset - way) / offset) * offset_W;
  state.anchor_O = inverse(X_WO) * held_W;
  return held_W;
}

}  // namespace haptic
