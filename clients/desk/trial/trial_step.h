// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string>
#include <vector>

#include "clients/desk/trial/guarded_hand.h"

namespace haptic {

enum class Verdict { kPassed, kUnclear, kFailed };

/// One line of the table that a trial ends with.
struct TrialRow {
  std::string what, measured;
  Verdict verdict = Verdict::kPassed;
};

/// Watches what a device says while nothing is commanded.
class LookStep {
 public:
  static constexpr double kTime = 5;  // [s]

  void note(const DeviceState& device, double t);
  std::vector<TrialRow> rows() const;

 private:
  double t_ = 0, last_fresh_ = 0, longest_silence_ = 0, fastest_ = 0;
  uint64_t fresh_ = 0, backward_ = 0, unsound_ = 0;
  int64_t last_ns_ = 0;
  uint32_t flags_ = 0, any_flags_ = 0;
  Vec3 least_B_, most_B_;
  bool any_ = false;
};

/// Pushes along each axis that has a motor, in both directions, and compares the motion of the
/// handle with the push. Before each push a rest, then it rises, holds and falls.
class PushStep {
 public:
  static constexpr double kRest = 0.5, kRise = 0.4, kHold = 0.7, kFall = 0.4;  // [s]
  static constexpr double kPushTime = kRest + kRise + kHold + kFall;

  /// Pushes with the force and torque that these limits allow.
  explicit PushStep(const SafetyLimits& limits);

  double time() const { return 2 * kPushTime * axes_; }
  Wrench wanted(double t) const;
  void note(const DeviceState& device, double t);
  std::vector<TrialRow> rows() const;

 private:
  /// Sum of where the handle was, from where it was first: its way and its rotation vector.
  struct Place {
    Vec3 way, turn;
    double samples = 0;

    double mean(int axis) const { return (axis < 3 ? way[axis] : turn[axis - 3]) / samples; }
  };
  /// Before a push, and at its end.
  struct Seen {
    Place rest, hold;
  };

  bool is_seen(int push) const;
  double response(int axis) const;

  double force_, torque_;
  int axes_;
  Pose X_first_;
  bool any_ = false;
  std::array<Seen, 12> seen_{};
};

/// Rises to the largest force along one axis within 3 s, holds it for 1 s and lets go within 1 s,
/// with a damper. The hand holds against it.
class FullStep {
 public:
  static constexpr double kTime = 5;  // [s]

  explicit FullStep(const SafetyLimits& limits) : limits_(limits) {}

  Wrench wanted(const DeviceState& device, double t) const;
  void note(const DeviceState& device, const Wrench& F_B, double t);
  std::vector<TrialRow> rows() const;

 private:
  SafetyLimits limits_;
  double peak_ = 0;  // [N]
  double t_ = 0;
  bool saturated_ = false;
};

}  // namespace haptic
