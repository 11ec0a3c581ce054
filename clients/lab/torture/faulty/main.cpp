// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-faulty-contact: haptic-contact that corrupts its answers on order. For the tests and
// hapt torture; a session starts it only if HAPTICD_LIBEXEC names a folder where it replaces
// haptic-contact.
#include <limits>
#include <random>

#include "clients/lab/torture/faulty/fault_order.h"
#include "contact/loop.h"
#include "proto/os/queued_order.h"

namespace haptic {
namespace {

constexpr int64_t kLookNs = 1'000'000;  // [ns] between looks for orders while an answer is delayed

ContactFault in_force = ContactFault::kHealthy;

void look_for_orders() {
  if (const int order = take_order(); order != 0) in_force = static_cast<ContactFault>(order);
}

void spoil(ContactSet& answer, double value) {
  for (Contact& contact : answer.contacts) {
    contact.object_point_O = contact.normal_O = {value, value, value};
    contact.extent = value;
  }
  answer.X_WG.p = {value, value, value};
  in_force = ContactFault::kHealthy;
}

/// Finite, plausible and wrong: shifts each plane by up to 20 mm and tilts it by up to 60°.
void lie(ContactSet& answer) {
  static std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  constexpr double kOff = 20e-3;  // [m]
  for (Contact& plane : answer.contacts) {
    plane.object_point_O += kOff * unit(random) * plane.normal_O;
    const Vec3 tilt{unit(random), unit(random), unit(random)};
    plane.normal_O = plane.shading_normal_O = normalized(plane.normal_O + 0.5 * tilt);
  }
}

/// Periods of the servo that an answer takes; 0: no delay.
int64_t slowness() {
  if (in_force == ContactFault::kTenTimes) return 10;
  return in_force == ContactFault::kThousandTimes ? 1000 : 0;
}

/// The heartbeat continues: hapticd would replace a process that hangs, and this is the worse case.
void hold_back(Child<ContactChannels>& child) {
  const int64_t begin_ns = now_ns();
  const int64_t period = period_ns(child.config().servo_rate);
  while (!child.stopping() && now_ns() < begin_ns + slowness() * period) {
    sleep_until(now_ns() + kLookNs);
    child.segment().beat(child.segment().header().heartbeat.load() + 1, now_ns());
    look_for_orders();
  }
}

void publish(Child<ContactChannels>& child, ContactSet& answer) {
  look_for_orders();
  hold_back(child);
  if (in_force == ContactFault::kNaN) spoil(answer, std::numeric_limits<double>::quiet_NaN());
  if (in_force == ContactFault::kInfinity) spoil(answer, std::numeric_limits<double>::infinity());
  if (in_force == ContactFault::kLies) lie(answer);
  child.channels().sets.publish(answer);
}

int run(const ChildArguments& arguments) {
  catch_orders();
  return run_contact(arguments, publish);
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  return haptic::run_child(argc, argv, haptic::run);
}
