// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "clients/desk/trial/weight_fit.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Where and how an arm is weighed.
struct WeighPlan {
  Vec3 centre_B;           // of its workspace
  double radius = 0;       // of that [m]
  bool is_planar = false;  // it moves in the plane z = 0 of B
  double stiffness = 200;  // of the spring that leads it [N/m]
  double damping = 2;      // that the device renders stably [N·s/m]
  double force = 0;        // that may be commanded [N]
  double turning = 0;      // stiffness that keeps the handle's orientation [N·m/rad]; 0: none does
  Vec3 down_B;             // of the session file; zero: the device's own
  size_t n_links = 0;
};

/// Why weighing ends before its time.
enum class WeighEnd { kNone, kTouched, kUnasked, kLeftBehind };

/// Leads a bare arm through twelve places, each from below and from above, and notes the force that
/// holds it.
///
///   inputs   the device's samples, and the holding wrench of unit masses at each place
///   way      up by 20 mm from where the arm rests, to each corner of an icosahedron, 60 % of the
///   workspace's
///            radius wide, the nearest first; up through it by 16 mm, askew so that every joint
///            moves, and back; home at the end
///   force    k e + I + B (v_s − v), İ = k e/0.3 s, e from the handle to the place s that is asked
///            for, which goes 40 mm/s on the way and 8 mm/s through a place
///   place    within 3 mm of it: the mean force rising is weight + friction, sinking weight −
///            friction, so their mean is the weight, half their difference the friction
///   ends     at home, or with zero force: by a touch (a button, 0.15 m/s), 5 mm aside of the way
///            that was asked for, or 20 mm behind (heavier than the force that is allowed, or
///            stuck)
///   bound    the force by what holds this (GuardedHand), the time by the length of the way, 90 s
class Weighing {
 public:
  static constexpr size_t kPlaces = 12;

  Weighing(const WeighPlan& plan, HoldingOf holding);

  Wrench wanted(const DeviceState& device, double t);
  void note(const DeviceState& device, const Wrench& F_B);
  bool is_over() const { return end_ != WeighEnd::kNone || (begun_ && leg_ == legs_.size()); }
  WeighEnd end() const { return end_; }
  /// Returns the places that have been passed both ways.
  const std::vector<WeighedPlace>& places() const { return places_; }
  WeightFit fit() const { return fit_weight(places_, plan_.down_B, plan_.n_links); }

 private:
  /// A straight way.
  struct Leg {
    Vec3 to_B;
    double speed;                 // [m/s]
    std::optional<Vec3> through;  // the place that it leads through
    bool sinks = false;
  };
  struct Sum {
    Vec3 force_B;
    double n = 0;
  };

  void begin(const DeviceState& device);
  void go_on(const DeviceState& device, double dt);
  WeighEnd why_end(const DeviceState& device) const;
  void finish_place();

  WeighPlan plan_;
  HoldingOf holding_;
  Vec3 up_B_;
  std::vector<Leg> legs_;
  size_t leg_ = 0;
  Vec3 from_B_;  // of the handle, where the leg began
  Vec3 asked_B_, v_asked_B_;
  Quat rest_;  // of the handle's orientation
  Wrench integral_B_;
  Sum rising_, sinking_;
  std::vector<Vec3> columns_;
  std::vector<WeighedPlace> places_;
  double t_ = 0;
  bool begun_ = false;
  WeighEnd end_ = WeighEnd::kNone;
};

}  // namespace haptic
