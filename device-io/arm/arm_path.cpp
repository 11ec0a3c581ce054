// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/arm/arm_path.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {

void ArmPath::rest_at(const Pose& X_B) {
  knots_[0] = {0, X_B};
  size_ = 1;
}

void ArmPath::add(int64_t t_ns, const Pose& X_B) {
  HAPTIC_ASSERT(t_ns > back(0).t_ns);
  knots_[size_++ % kRoom] = {t_ns, X_B};
}

Pose ArmPath::at(int64_t t_ns) const {
  const int64_t then_ns = t_ns - delay_ns_;
  if (then_ns >= back(0).t_ns) return back(0).X_B;
  const size_t n = std::min(size_, kRoom);
  for (size_t i = 1; i < n; ++i) {
    const Knot &from = back(i), &to = back(i - 1);
    if (then_ns < from.t_ns) continue;
    const double share =
        static_cast<double>(then_ns - from.t_ns) / static_cast<double>(to.t_ns - from.t_ns);
    if (share == 0) return from.X_B;
    return {from.X_B.p + share * (to.X_B.p - from.X_B.p), slerp(from.X_B.q, to.X_B.q, share)};
  }
  return back(n - 1).X_B;
}

}  // namespace haptic
