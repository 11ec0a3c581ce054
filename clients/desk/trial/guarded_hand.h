// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "servo/safety/safety.h"

namespace haptic {

/// Why a step of a trial ends before its time.
enum class TrialEnd {
  kNone,
  kLost,     // for 0.1 s the device has not answered, or its place was unknown
  kFault,    // safety latched a fault
  kTooFast,  // the hand did not hold the handle
  kTooFar,   // likewise
};

/// The servo's own safety around the wrench of a trial, with limits for one that nobody has felt
/// yet: a share of the largest force, a slow hand, a short way. What ends a trial stays: zero
/// wrench from then on.
class GuardedHand {
 public:
  static constexpr double kMostWay = 0.08;  // from where the step began [m]; a hand that gives way

  /// `share` of the limits' force and torque, 0 to 1; 0: nothing is commanded and a hand may move
  /// as it likes.
  GuardedHand(const SafetyLimits& limits, double share, double most_way = kMostWay);

  /// The wrench that the device is told in this tick of `dt` seconds.
  Wrench tick(const DeviceState& device, int64_t now_ns, const Wrench& wanted_B, double dt);

  TrialEnd end() const { return end_; }
  /// The force and torque that may be commanded.
  const SafetyLimits& limits() const { return limits_; }

 private:
  TrialEnd why_end(const DeviceState& device, uint32_t flags) const;

  SafetyLimits limits_;
  bool pushes_;
  double most_way_;
  SafetyState state_;
  Vec3 begin_B_;
  bool begun_ = false;
  double untrusted_ = 0;  // since the last sample that a force may follow from [s]
  TrialEnd end_ = TrialEnd::kNone;
};

}  // namespace haptic
