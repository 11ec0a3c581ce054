// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/replay/recorded_motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "device-io/hand/intended_motion.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kNsPerS = 1e9;
constexpr double kPeak = 1.875;  // of a minimum-jerk motion, relative to its mean velocity

int64_t ns_of(double seconds) {
  return std::llround(seconds * kNsPerS);
}

int64_t return_time(const Pose& from, const Pose& to) {
  const double way = norm(to.p - from.p);
  const double turn = norm(to_rotation_vector(to.q * conjugate(from.q)));
  const double seconds = kPeak * std::max(way / kReturnSpeed, turn / kReturnSpin);
  return std::max(kLeastReturnNs, ns_of(seconds));
}

}  // namespace

RecordedMotion::RecordedMotion(HandCurve curve, const ReplayConfig& config)
    : curve_(std::move(curve)), speed_(config.speed) {
  HAPTIC_ASSERT(speed_ > 0);
  const int64_t first_ns = curve_.samples().front().t_ns, last_ns = curve_.samples().back().t_ns;
  from_ns_ = first_ns + ns_of(config.from);
  to_ns_ = config.to > 0 ? std::min(last_ns, first_ns + ns_of(config.to)) : last_ns;
  if (from_ns_ >= to_ns_) {
    throw std::runtime_error("[device.replay] from and to leave nothing of a recording of " +
                             std::to_string(static_cast<double>(last_ns - first_ns) / kNsPerS) +
                             " s; `from` must be below `to` and its end");
  }
  length_ns_ = std::llround(static_cast<double>(to_ns_ - from_ns_) / speed_);
  if (config.loop != 0) return_ns_ = return_time(curve_.at(to_ns_).X_BH, curve_.at(from_ns_).X_BH);
}

DeviceState RecordedMotion::at(int64_t elapsed_ns) const {
  int64_t round_ns = 0;  // start of this round
  if (return_ns_ > 0 && elapsed_ns > 0) {
    const int64_t cycle_ns = length_ns_ + return_ns_;
    round_ns = elapsed_ns / cycle_ns * cycle_ns;
  }
  const int64_t along_ns = elapsed_ns - round_ns;
  if (return_ns_ > 0 && along_ns > length_ns_) {
    DeviceState state = on_return(along_ns - length_ns_);
    state.t_ns = elapsed_ns;
    return state;
  }
  const int64_t asked_ns = from_ns_ + std::llround(static_cast<double>(along_ns) * speed_);
  DeviceState state = curve_.at(std::min(asked_ns, to_ns_));
  if (asked_ns > to_ns_ + kSnapNs) {
    state.V_BH = {};
    state.flags = (state.flags & ~uint32_t{kDeviceFresh}) | kDeviceHeld | kDeviceEnded;
  }
  // instants near a sample are as exact as the recording
  const int64_t late_ns = asked_ns - state.t_ns;
  state.t_ns = elapsed_ns - std::llround(static_cast<double>(late_ns) / speed_);
  state.V_BH = {speed_ * state.V_BH.v, speed_ * state.V_BH.w};
  return state;
}

/// Minimum jerk from the end of the part to its beginning.
DeviceState RecordedMotion::on_return(int64_t along_ns) const {
  DeviceState state = curve_.at(to_ns_);
  const Pose from = state.X_BH, to = curve_.at(from_ns_).X_BH;
  const auto [s, rate] =
      minimum_jerk(static_cast<double>(along_ns) / static_cast<double>(return_ns_),
                   static_cast<double>(return_ns_) / kNsPerS);
  const Vec3 turn_B = to_rotation_vector(to.q * conjugate(from.q));
  state.X_BH = {from.p + s * (to.p - from.p), normalized(slerp(from.q, to.q, s))};
  state.V_BH = {rate * (to.p - from.p), rate * turn_B};
  state.flags = (state.flags & kDeviceSimulated) | kDeviceFresh | kDeviceOpenLoop;
  return state;
}

}  // namespace haptic
