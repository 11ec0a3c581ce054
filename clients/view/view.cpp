// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/view.h"

#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr int64_t kMeterSpan = 1'000'000'000;    // [ns], over which a rate is taken
constexpr int64_t kMeterStep = kMeterSpan / 16;  // [ns], between two marks

}  // namespace

uint32_t solver_of(const View& view) {
  return view.has_control && view.control.solver > 0 ? view.control.solver - 1 : view.solver;
}

bool is_led(const View& view) {
  return (view.servo.device.flags & kDeviceLed) != 0;
}

Vec3 intent_of(const View& view) {
  return is_led(view) && view.has_control ? view.control.X_WT_intent.p : view.servo.X_WT.p;
}

double age_of(const View& view, bool has, int64_t t_ns) {
  if (!has) return std::numeric_limits<double>::quiet_NaN();
  return 1e-9 * static_cast<double>(view.now_ns - t_ns);
}

void RateMeter::add(int64_t t_ns, uint64_t count) {
  if (!marks_.empty() && count < marks_.back().count) marks_.clear();
  if (marks_.size() > 1 && t_ns - marks_[marks_.size() - 2].t_ns < kMeterStep) marks_.pop_back();
  marks_.push_back({t_ns, count});
  while (marks_.size() > 2 && t_ns - marks_[1].t_ns >= kMeterSpan) marks_.erase(marks_.begin());
}

double RateMeter::rate() const {
  if (marks_.size() < 2) return 0;
  const double seconds = 1e-9 * static_cast<double>(marks_.back().t_ns - marks_.front().t_ns);
  const double counts = static_cast<double>(marks_.back().count - marks_.front().count);
  return seconds > 0 ? counts / seconds : 0;
}

}  // namespace haptic
