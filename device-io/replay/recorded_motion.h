// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "device-io/replay/hand_curve.h"

namespace haptic {

/// A recorded motion as it is played: a part of the recording, at a speed, once or again and again.
///
/// With `loop` the hand returns from the end of the part to its beginning by a minimum-jerk motion
/// (Flash & Hogan 1985), straight and by the shorter turn, in at least kLeastReturnNs and no faster
/// than kReturnSpeed and kReturnSpin: the pose never jumps. On this way, which nobody has recorded
/// and which may lead through objects, the device is not kDeviceHomed: the servo renders nothing,
/// contact places the proxy where the hand is, and the next round begins with a soft start.
class RecordedMotion {
 public:
  RecordedMotion(HandCurve curve, const ReplayConfig& config);

  /// The state `elapsed_ns` after the start of the motion; its t_ns is the instant of its pose,
  /// counted likewise. Twists are those of the motion as it is played. At speed 1 the samples come
  /// bit for bit, as HandCurve::at() says. After the end of the part: its last pose at rest,
  /// kDeviceHeld | kDeviceEnded.
  DeviceState at(int64_t elapsed_ns) const;

  const HandCurve& curve() const { return curve_; }
  /// The duration of one round as it is played, without the return [ns].
  int64_t length_ns() const { return length_ns_; }
  int64_t return_ns() const { return return_ns_; }

 private:
  DeviceState on_return(int64_t along_ns) const;

  HandCurve curve_;
  double speed_;
  int64_t from_ns_, to_ns_;  // on the recording's clock
  int64_t length_ns_, return_ns_ = 0;
};

inline constexpr int64_t kLeastReturnNs = 300'000'000;  // [ns]; a faster reach would be a blow
inline constexpr double kReturnSpeed = 0.25;  // at the fastest [m/s]; a slow reach of a person
inline constexpr double kReturnSpin = 2;      // likewise [rad/s]

}  // namespace haptic
