// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/trial_step.h"

#include <algorithm>
#include <cmath>

#include "proto/math/quat.h"
#include "proto/os/text.h"
#include "servo/tick.h"

namespace haptic {
namespace {

constexpr double kMostSilence = 0.1;  // between samples [s]; longer than any pause of a machine
constexpr double kLeastWay = 0.005;   // of a hand that was asked to move [m]
constexpr double kMostHandSpeed = 5;  // [m/s]; no hand holding a handle is faster
// smallest response that counts: twice the amplitude of a hand's tremor, which the mean takes away
constexpr double kLeastMotion = 2e-4;  // [m]
constexpr double kLeastTurn = 3e-3;    // [rad]; the same at 70 mm
constexpr double kWindow = 0.3;        // of the mean [s]; three turns of a tremor of 8 to 12 Hz
constexpr double kFullRise = 3, kFullHold = 1, kFullFall = 1;  // of the full force [s]
constexpr double kReached = 0.95;  // of the largest force; the damper may take the rest
constexpr std::array<const char*, 6> kAxes{"x", "y", "z", "turning x", "turning y", "turning z"};

/// From 0 up to 1, on for `hold`, and down.
double trapezium(double t, double rise, double hold, double fall) {
  if (t < rise) return t / rise;
  return std::clamp(1 - (t - rise - hold) / fall, 0.0, 1.0);
}

Vec3 unit(int axis) {
  Vec3 e;
  e[axis] = 1;
  return e;
}

}  // namespace

void LookStep::note(const DeviceState& device, double t) {
  t_ = t;
  flags_ = device.flags;
  any_flags_ |= device.flags;
  if ((device.flags & kDeviceFresh) != 0) {
    ++fresh_;
    backward_ += device.t_ns < last_ns_ ? 1 : 0;
    last_ns_ = device.t_ns;
    last_fresh_ = t;
  }
  longest_silence_ = std::max(longest_silence_, t - last_fresh_);
  if (!is_sound(device)) {
    ++unsound_;
    return;
  }
  // positions from before homing are invented
  if ((device.flags & kDeviceHomed) == 0 || (device.flags & kDeviceLost) != 0) return;
  fastest_ = std::max(fastest_, norm(device.V_BH.v));
  const Vec3& p = device.X_BH.p;
  if (!any_) least_B_ = most_B_ = p;
  any_ = true;
  for (int i = 0; i < 3; ++i) {
    least_B_[i] = std::min(least_B_[i], p[i]);
    most_B_[i] = std::max(most_B_[i], p[i]);
  }
}

std::vector<TrialRow> LookStep::rows() const {
  const auto verdict = [](bool good) { return good ? Verdict::kPassed : Verdict::kFailed; };
  const double rate = t_ > 0 ? static_cast<double>(fresh_) / t_ : 0;
  const Vec3 way = most_B_ - least_B_;
  const bool homed = (flags_ & kDeviceHomed) != 0, lost = (flags_ & kDeviceLost) != 0;
  const bool doubtful = (any_flags_ & (kDeviceStale | kDeviceNoisy)) != 0;
  // a hand that did not move leaves it open
  const bool moved = std::max({way.x, way.y, way.z}) > kLeastWay;
  return {{"it answers", formatted("%.0f samples a second", rate), verdict(fresh_ > 0 && !lost)},
          {"without gaps", formatted("longest silence %.1f ms", 1e3 * longest_silence_),
           verdict(fresh_ > 0 && longest_silence_ < kMostSilence)},
          {"answers match the requests", doubtful ? "stale or noisy" : "always",
           verdict(!doubtful && backward_ == 0 && unsound_ == 0)},
          {"homed", homed ? "yes" : "no: home it as its manual says, begin again", verdict(homed)},
          {"encoders follow the hand",
           formatted("x %.0f mm, y %.0f mm, z %.0f mm", 1e3 * way.x, 1e3 * way.y, 1e3 * way.z),
           moved ? Verdict::kPassed : Verdict::kUnclear},
          {"speed of a hand", formatted("at most %.2f m/s", fastest_),
           verdict(fastest_ < kMostHandSpeed)}};
}

PushStep::PushStep(const SafetyLimits& limits)
    : force_(limits.max_force), torque_(limits.max_torque), axes_(limits.max_torque > 0 ? 6 : 3) {}

Wrench PushStep::wanted(double t) const {
  const int push = static_cast<int>(t / kPushTime);
  if (t < 0 || push >= 2 * axes_) return {};
  const int axis = push / 2;
  const double since = t - push * kPushTime - kRest;
  const double share = since < 0 ? 0 : trapezium(since, kRise, kHold, kFall);
  const double sign = push % 2 == 0 ? share : -share;
  Wrench F_B;
  if (axis < 3) {
    F_B.f = sign * force_ * unit(axis);
  } else {
    F_B.t = sign * torque_ * unit(axis - 3);
  }
  return F_B;
}

void PushStep::note(const DeviceState& device, double t) {
  const int push = static_cast<int>(t / kPushTime);
  if (t < 0 || push >= 2 * axes_ || !is_sound(device)) return;
  if (!any_) X_first_ = device.X_BH;
  any_ = true;
  constexpr double kEnd = kRest + kRise + kHold;
  const double since = t - push * kPushTime;
  Seen& seen = seen_[static_cast<size_t>(push)];
  const bool rests = since > kRest - kWindow && since <= kRest;
  const bool holds = since > kEnd - kWindow && since <= kEnd;
  if (!rests && !holds) return;
  Place& place = rests ? seen.rest : seen.hold;
  place.way += device.X_BH.p - X_first_.p;
  place.turn += to_rotation_vector(device.X_BH.q * conjugate(X_first_.q));
  place.samples += 1;
}

bool PushStep::is_seen(int push) const {
  const Seen& seen = seen_[static_cast<size_t>(push)];
  return seen.rest.samples > 0 && seen.hold.samples > 0;
}

/// Half the difference of the two pushes, in which a steady drift of the hand goes away [m or rad].
double PushStep::response(int axis) const {
  const auto along = [&](int push) {
    const Seen& seen = seen_[static_cast<size_t>(push)];
    return seen.hold.mean(axis) - seen.rest.mean(axis);
  };
  return 0.5 * (along(2 * axis) - along(2 * axis + 1));
}

std::vector<TrialRow> PushStep::rows() const {
  std::vector<TrialRow> rows;
  for (int axis = 0; axis < axes_; ++axis) {
    TrialRow row{std::string("pushes along ") + kAxes[static_cast<size_t>(axis)], "not reached",
                 Verdict::kUnclear};
    if (axis >= 3) row.what = kAxes[static_cast<size_t>(axis)];
    if (is_seen(2 * axis) && is_seen(2 * axis + 1)) {
      const double moved = response(axis);
      const double least = axis < 3 ? kLeastMotion : kLeastTurn;
      row.measured = axis < 3 ? formatted("the handle went %+.2f mm with it", 1e3 * moved)
                              : formatted("the handle turned %+.1f mrad with it", 1e3 * moved);
      row.verdict = moved > least    ? Verdict::kPassed
                    : moved < -least ? Verdict::kFailed
                                     : Verdict::kUnclear;
      if (row.verdict == Verdict::kFailed) {
        row.measured += "; try again with a still hand, else a sign is wrong";
      }
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

Wrench FullStep::wanted(const DeviceState& device, double t) const {
  if (t < 0 || t > kTime) return {};
  const double push = limits_.max_force * trapezium(t, kFullRise, kFullHold, kFullFall);
  return {push * unit(0) - 0.5 * limits_.max_damping * device.V_BH.v, {}};
}

void FullStep::note(const DeviceState& device, const Wrench& F_B, double t) {
  t_ = t;
  peak_ = std::max(peak_, norm(F_B.f));
  saturated_ |= (device.flags & kDeviceSaturated) != 0;
}

std::vector<TrialRow> FullStep::rows() const {
  const bool reached = peak_ >= kReached * limits_.max_force && t_ > kFullRise + kFullHold;
  return {{"holds the largest force",
           formatted("%.2f N of %.2f N", peak_, limits_.max_force) +
               (saturated_ ? ", motors at their limit" : ""),
           reached ? Verdict::kPassed : Verdict::kFailed}};
}

}  // namespace haptic
