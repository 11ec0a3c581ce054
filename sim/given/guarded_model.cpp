// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/given/guarded_model.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/wire/scene_pose.h"
#include "sim/given/statement.h"

namespace haptic {
namespace {

// sizes that hold for 20 g to 1 kg, 10 to 100 Hz and statements that are 30 % wrong; twice or half
// of each holds as well (docs/clients-that-give.md)
constexpr double kGain = 0.1;          // share of the gap that a frame takes over
constexpr double kPurse = 1e-3;        // while it is touched [J]
constexpr double kApart = 0.5;         // so long without a push ends a touch [s]
constexpr double kApartPurse = 5e-3;   // then [J]
constexpr double kApartPower = 10e-3;  // with which it fills [W]
constexpr double kTrust = 1e-3;        // debt at which frames are not followed at all [J]
constexpr double kSlew = 20;           // of the force, by a frame [N/s]
constexpr double kSpeedSlew = 0.3;     // force that a correction of the twist may amount to [N]
constexpr double kDebtDamping = 5;     // at a whole purse of debt [N·s/m]
constexpr double kNormTime = 2;        // in which an own force becomes the norm [s]
constexpr double kSaidTime = 1;        // for which it is said that frames are held back [s]
constexpr double kSaidAt = 1;          // what they asked for [N]
constexpr double kLever = 0.05;        // a torque counts as the force at this distance [m]

double size_of(const Wrench& F) {
  return std::sqrt(norm_squared(F.f) + norm_squared(F.t) / (kLever * kLever));
}
double size_of(const Twist& way) {
  return std::sqrt(norm_squared(way.v) + kLever * kLever * norm_squared(way.w));
}

/// The factor that makes a size at most that.
double cut(double size, double most) {
  return size > most ? most / size : 1;
}

/// Largest h in [0, 1] with a h + b h² ≤ most; most ≥ 0.
double affordable(double a, double b, double most) {
  if (a + b <= most) return 1;
  const double root = std::sqrt(std::max(0.0, a * a + 4 * b * most));
  // the form without a difference of like numbers
  const double h = a > 0 ? 2 * most / (a + root) : b > 0 ? (root - a) / (2 * b) : 1;
  return std::clamp(h, 0.0, 1.0);
}

}  // namespace

void GuardedModel::say(const GivenMotion& said) {
  said_ = said;
  mass_ = mass_of_mobility(said.mobility);
}

/// The purse decides: it is touched, and its client does not state that it drives it.
bool GuardedModel::is_bound() const {
  return since_touched_ < kApart && !(said_.power > 0);
}

Wrench GuardedModel::norm_at(const Pose& X_WO) const {
  return g_W_ + -(K0_ * way_between(X_ref_, X_WO));
}

/// The own force that the client states, at rest.
Wrench GuardedModel::stated_at(const Pose& X_WO) const {
  return mass_ * said_.acceleration_W + Mat6{said_.damping} * said_.V_WO +
         -(Mat6{said_.stiffness} * way_between(said_.X_WO, X_WO));
}

double GuardedModel::own_energy() const {
  const Twist way = way_between(X_ref_, at_.X_WO);
  return 0.5 * dot(mass_ * at_.V_WO, at_.V_WO) + 0.5 * dot(K0_ * way, way) - dot(g_W_, way);
}

bool GuardedModel::is_held_back() const {
  return asked_ > kSaidAt && done_ < 0.5 * asked_;
}

Twist GuardedModel::acceleration() const {
  return moved_by(said_.mobility, norm_at(at_.X_WO) + extra_W_ + -(Mat6{said_.damping} * at_.V_WO));
}

void GuardedModel::place(const ModelState& at, const GivenMotion& said) {
  say(said);
  at_ = at;
  X_ref_ = said.X_WO;
  K0_ = {said.stiffness};
  g_W_ = stated_at(X_ref_);
  extra_W_ = {};
  left_ = led_ = {};
  ticks_left_ = 0;
  purse_ = kPurse;
  since_touched_ = 1e9;
  paid_ = 0;
  energy_ = own_energy();
}

void GuardedModel::correct(const ModelState& replayed, const GivenMotion& said, int ticks) {
  say(said);
  const StateGap gap = gap_between(at_, replayed);
  const StateGap answers{answering(gap.way), answering(gap.velocity)};
  left_ = {kGain * answers.way, kGain * answers.velocity};
  led_ = {gap.way - answers.way, gap.velocity - answers.velocity};
  ticks_left_ = std::max(1, ticks);
}

/// An impulse of the extra force: braking costs nothing, driving what `may` has left.
void GuardedModel::drive(const Wrench& impulse_W, double& may) {
  const Twist change = moved_by(said_.mobility, impulse_W);
  const double along = dot(impulse_W, at_.V_WO), squared = dot(impulse_W, change);
  if (!(squared > 0)) return;
  const double brake = std::clamp(-along / squared, 0.0, 1.0);
  const double slope = along + brake * squared, rest = 1 - brake;
  const double share = affordable(rest * slope, 0.5 * rest * rest * squared, may);
  const double u = share * rest;
  may -= u * slope + 0.5 * u * u * squared;
  at_.V_WO = at_.V_WO + (brake + u) * change;
}

void GuardedModel::advance(const Wrench& force_W, double dt) {
  const int n = steps_of_model(dt);
  const double h = n > 0 ? dt / n : 0;
  const bool drives = said_.power > 0;
  const double debt = drives ? 0 : kDebtDamping * std::clamp(-purse_ / kPurse, 0.0, 1.0);
  double may = drives ? HUGE_VAL : std::max(0.0, purse_);
  // the push of the tick's beginning, as the counters have it, without its saw-tooth in the twist
  const Twist half = 0.5 * dt * moved_by(said_.mobility, force_W);
  at_.V_WO = at_.V_WO + half;
  for (int i = 0; i < n; ++i) {
    at_.X_WO = extrapolate(at_.X_WO, at_.V_WO, 0.5 * h);
    const Wrench damped_W = Mat6{said_.damping} * at_.V_WO +
                            Wrench{debt * at_.V_WO.v, debt * kLever * kLever * at_.V_WO.w};
    const Wrench own_W = force_W + norm_at(at_.X_WO) + -damped_W;
    at_.V_WO = at_.V_WO + h * moved_by(said_.mobility, own_W);
    if (extra_W_ != Wrench{}) drive(h * extra_W_, may);
    at_.X_WO = extrapolate(at_.X_WO, at_.V_WO, 0.5 * h);
  }
  at_.V_WO = at_.V_WO - half;
}

/// The part of a motion along which pushes move the object.
Twist GuardedModel::answering(const Twist& change) const {
  return moved_by(said_.mobility, mass_ * change);
}

/// A step's share of what is led. It is no push, so that neither the purse nor the norm know of it.
void GuardedModel::take_led() {
  const StateGap part{1.0 / ticks_left_ * led_.way, 1.0 / ticks_left_ * led_.velocity};
  led_ = {led_.way - part.way, led_.velocity - part.velocity};
  const double before = own_energy();
  at_ = moved(at_, 1, part);
  energy_ += own_energy() - before;
}

/// A step's share of what is left of the correction, as far as the purse pays.
void GuardedModel::take_correction(const HandsOnObject& hands, double dt, double trust) {
  if (ticks_left_ == 0) return;
  take_led();
  StateGap part{1.0 / ticks_left_ * left_.way, 1.0 / ticks_left_ * left_.velocity};
  left_ = {left_.way - part.way, left_.velocity - part.velocity};
  --ticks_left_;
  // what is left moves as the model does
  left_.way = left_.way + dt * left_.velocity;
  const Wrench held = Mat6{said_.stiffness} * left_.way + Mat6{said_.damping} * left_.velocity;
  left_.velocity = left_.velocity - dt * moved_by(said_.mobility, held);
  const double asked = hands.stiffness * size_of(part.way);
  if (is_bound()) {
    const double k = std::max(hands.stiffness, 1.0);
    part.way = cut(k * size_of(part.way), trust * kSlew * dt) * part.way;
    part.velocity = cut(size_of(mass_ * part.velocity), trust * kSpeedSlew * dt) * part.velocity;
  }
  const Wrench force_W = 1 / dt * hands.impulse_W;
  const double to_spring = -dot(force_W, part.way);
  const double k = force_W == Wrench{} ? 0 : hands.stiffness;
  const double spring_curve = 0.5 * k * norm_squared(part.way.v);
  const double a =
      dot(mass_ * at_.V_WO, part.velocity) - dot(norm_at(at_.X_WO), part.way) + to_spring;
  const double b = 0.5 * dot(mass_ * part.velocity, part.velocity) +
                   0.5 * dot(K0_ * part.way, part.way) + spring_curve;
  const double h = is_bound() ? affordable(a, b, std::max(0.0, purse_)) : 1;
  const double cost = a * h + b * h * h;
  purse_ -= cost;
  paid_ = cost;
  if (is_bound()) {
    asked_ += asked;
    done_ += h * hands.stiffness * size_of(part.way);
  }
  at_ = moved(at_, h, part);
}

void GuardedModel::keep_apart(double dt) {
  const Twist way = way_between(X_ref_, said_.X_WO);
  const double before = own_energy();
  // another place of reference, and the client's stiffness about it
  const Wrench there_W = g_W_ + -(K0_ * way);
  X_ref_ = said_.X_WO;
  K0_ = {said_.stiffness};
  g_W_ = there_W + std::min(1.0, dt / kNormTime) * (stated_at(X_ref_) + -there_W);
  energy_ += own_energy() - before;
  purse_ = std::min(kApartPurse, purse_ + kApartPower * dt);
}

void GuardedModel::follow(const HandsOnObject& hands, double dt) {
  const double trust = is_bound() ? std::clamp(1 + purse_ / kTrust, 0.0, 1.0) : 1;
  Wrench to_go = stated_at(at_.X_WO) + -norm_at(at_.X_WO) + -extra_W_;
  to_go = 1.0 / std::max(1, ticks_left_) * to_go;
  const double share = is_bound() ? cut(size_of(to_go), trust * kSlew * dt) : 1;
  extra_W_ = extra_W_ + share * to_go;
  take_correction(hands, dt, trust);
}

void GuardedModel::step(const HandsOnObject& hands, double dt) {
  HAPTIC_ASSERT(dt >= 0 && dt <= kMostReplay);
  if (!(dt > 0)) return;
  // all at the instant of the hands: what the last correction has cost is in the energy now
  const double energy = own_energy() + hands.spring;
  purse_ += hands.work - (energy - energy_) + paid_;
  energy_ = energy;
  paid_ = 0;
  const double fading = std::max(0.0, 1 - dt / kSaidTime);
  asked_ *= fading;
  done_ *= fading;
  const bool is_pushed = hands.impulse_W != Wrench{};
  since_touched_ = is_pushed ? 0 : since_touched_ + dt;
  advance(1 / dt * hands.impulse_W, dt);
  const Twist late = moved_by(said_.mobility, hands.late_W);
  if (late != Twist{}) at_.X_WO = moved(at_.X_WO, late);
  if (since_touched_ < kApart) {
    purse_ = std::min(purse_ + said_.power * dt, kPurse + said_.power);
  } else {
    keep_apart(dt);
  }
  follow(hands, dt);
}

}  // namespace haptic
