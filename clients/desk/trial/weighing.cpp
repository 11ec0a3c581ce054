// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/weighing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "servo/tick.h"

namespace haptic {
namespace {

constexpr double kOfRadius = 0.6;      // of the workspace, clear of its edge
constexpr double kHalfWay = 8e-3;      // below and above a place [m]; friction has turned by then
constexpr double kAskew = 0.5;         // level ways, over that
constexpr double kCounts = 3e-3;       // about a place, in which force counts [m]
constexpr double kLift = 20e-3;        // out of what it rests in [m]
constexpr double kTravel = 40e-3;      // between places [m/s]
constexpr double kCreep = 8e-3;        // through a place [m/s]; damping of 1 N·s/m makes 8 mN
constexpr double kIntegral = 0.3;      // time constant [s]; ten times that of mass and spring
constexpr double kTouchSpeed = 0.15;   // [m/s]; no arm that is led so is as fast
constexpr double kAside = 5e-3;        // of the way that was asked for [m]
constexpr double kMostBehind = 20e-3;  // of the place that is asked for [m]

/// Corners of an icosahedron of radius 1.
std::array<Vec3, Weighing::kPlaces> corners() {
  const double golden = std::numbers::phi, length = std::hypot(1, golden);
  std::array<Vec3, Weighing::kPlaces> all;
  size_t n = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double a : {-1.0, 1.0}) {
      for (const double b : {-golden, golden}) {
        Vec3 corner;
        corner[(axis + 1) % 3] = a / length;
        corner[(axis + 2) % 3] = b / length;
        all[n++] = corner;
      }
    }
  }
  return all;
}

/// Distance of p from the way between two places.
double aside_of(const Vec3& from, const Vec3& to, const Vec3& p) {
  const Vec3 way = to - from;
  const double squared = norm_squared(way);
  const double share = squared > 0 ? std::clamp(dot(p - from, way) / squared, 0.0, 1.0) : 0;
  return norm(p - from - share * way);
}

/// The way through a place, over its height: askew, so that all joints move, and the friction of
/// each turns its sign when the way is turned.
Vec3 askew(const Vec3& up_B, bool is_planar) {
  const Vec3 level_B = std::fabs(up_B.z) < 0.5 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  const Vec3 a = normalized(cross(up_B, level_B)), b = is_planar ? Vec3{} : cross(a, up_B);
  return up_B + kAskew * (a + b);
}

Vec3 at_most(const Vec3& a, double most) {
  const double length = norm(a);
  return length > most ? most / length * a : a;
}

}  // namespace

Weighing::Weighing(const WeighPlan& plan, HoldingOf holding)
    : plan_(plan), holding_(std::move(holding)) {}

void Weighing::begin(const DeviceState& device) {
  begun_ = true;
  const Vec3 home_B = asked_B_ = from_B_ = device.X_BH.p;
  rest_ = device.X_BH.q;
  GravityConfig unit;
  unit.down_B = plan_.down_B;
  unit.handle.mass = 1;
  const Vec3 lifts_B = holding_(unit).f;
  // an arm that lies flat is heavy in no direction
  up_B_ = norm(lifts_B) > 1 ? normalized(lifts_B) : Vec3{0, 1, 0};
  const Vec3 way_B = askew(up_B_, plan_.is_planar);
  std::vector<Vec3> left;
  for (Vec3 corner : corners()) {
    if (plan_.is_planar) corner.z = 0;
    left.push_back(plan_.centre_B + kOfRadius * plan_.radius * corner);
  }
  const Vec3 lifted_B = home_B + kLift * up_B_;
  legs_.push_back({lifted_B, kCreep, {}});
  for (Vec3 at_B = lifted_B; !left.empty();) {
    const auto nearest = std::ranges::min_element(
        left, {}, [&](const Vec3& place_B) { return norm(place_B - at_B); });
    const Vec3 below_B = *nearest - kHalfWay * way_B, above_B = *nearest + kHalfWay * way_B;
    legs_.push_back({below_B, kTravel, {}});
    legs_.push_back({above_B, kCreep, *nearest});
    legs_.push_back({below_B, kCreep, *nearest, true});
    at_B = below_B;
    left.erase(nearest);
  }
  legs_.push_back({lifted_B, kTravel, {}});
  legs_.push_back({home_B, kTravel, {}});
}

void Weighing::finish_place() {
  if (rising_.n > 0 && sinking_.n > 0 && !columns_.empty()) {
    const Vec3 up_B = rising_.force_B / rising_.n, down_B = sinking_.force_B / sinking_.n;
    places_.push_back({(up_B + down_B) / 2, dot(up_B - down_B, up_B_) / 2, columns_});
  }
  rising_ = sinking_ = {};
}

/// Moves the place that is asked for, and takes up the next leg where one is at its end.
void Weighing::go_on(const DeviceState& device, double dt) {
  const Leg& leg = legs_[leg_];
  const Vec3 left_B = leg.to_B - asked_B_;
  const double step = leg.speed * dt, length = norm(left_B);
  v_asked_B_ = length > 0 ? leg.speed / length * left_B : Vec3{};
  if (length > step) {
    asked_B_ += step / length * left_B;
    return;
  }
  asked_B_ = leg.to_B;
  if (leg.sinks) finish_place();
  from_B_ = device.X_BH.p;
  ++leg_;
}

WeighEnd Weighing::why_end(const DeviceState& device) const {
  if (device.buttons != 0 || norm(device.V_BH.v) > kTouchSpeed) return WeighEnd::kTouched;
  if (aside_of(from_B_, asked_B_, device.X_BH.p) > kAside) return WeighEnd::kUnasked;
  return norm(asked_B_ - device.X_BH.p) > kMostBehind ? WeighEnd::kLeftBehind : WeighEnd::kNone;
}

Wrench Weighing::wanted(const DeviceState& device, double t) {
  const double dt = std::clamp(t - t_, 0.0, 0.01);  // a longer pause is the machine's
  t_ = t;
  if (is_over() || !is_usable(device) || !is_sound(device)) return {};
  if (!begun_) begin(device);
  go_on(device, dt);
  end_ = why_end(device);
  if (is_over()) return {};
  const Vec3 behind_B = asked_B_ - device.X_BH.p;
  const Vec3 turned_B = to_rotation_vector(rest_ * conjugate(device.X_BH.q));
  const Vec3 spring_B = plan_.stiffness * behind_B, twist_B = plan_.turning * turned_B;
  integral_B_.f = at_most(integral_B_.f + dt / kIntegral * spring_B, plan_.force);
  integral_B_.t += dt / kIntegral * twist_B;
  return {spring_B + integral_B_.f + plan_.damping * (v_asked_B_ - device.V_BH.v),
          twist_B + integral_B_.t};
}

void Weighing::note(const DeviceState& device, const Wrench& F_B) {
  if (is_over() || !begun_ || !legs_[leg_].through) return;
  const Leg& leg = legs_[leg_];
  const double beyond = dot(device.X_BH.p - *leg.through, up_B_);
  if (std::fabs(beyond) > kCounts) return;
  if (rising_.n == 0) columns_.clear();
  if (columns_.empty() && beyond >= 0) {
    columns_ = holding_columns(holding_, plan_.down_B, plan_.n_links);
  }
  Sum& sum = leg.sinks ? sinking_ : rising_;
  sum.force_B += F_B.f;
  ++sum.n;
}

}  // namespace haptic
