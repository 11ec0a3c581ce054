// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/arm/arm_path.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {

void ArmPath::rest_at(const Pose& X_B) {
  knots_[0] = {0, X_B};
  size_ = 1;
}

void ArmPath::go(int64_t t_ns, int64_t arrival_ns, const Pose& X_B) {
  HAPTIC_ASSERT(arrival_ns > t_ns);
  const Pose from_B = commanded(t_ns);
  // what was still to come is given up
  while (size_ > 1 && back(0).t_ns >= t_ns) --size_;
  HAPTIC_ASSERT(size_ == 1 || back(0).t_ns < t_ns);
  if (back(0).t_ns < t_ns) knots_[size_++ % kRoom] = {t_ns, from_B};
  knots_[size_++ % kRoom] = {arrival_ns, X_B};
}

Pose ArmPath::at(int64_t t_ns) const {
  return commanded(t_ns - delay_ns_);
}

Pose ArmPath::commanded(int64_t then_ns) const {
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
