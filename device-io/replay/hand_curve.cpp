// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/replay/hand_curve.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr uint32_t kKeptFlags = kDeviceHomed | kDeviceSimulated;

DeviceState flagged(DeviceState state, uint32_t flags) {
  state.flags = (state.flags & kKeptFlags) | kDeviceOpenLoop | flags;
  return state;
}

DeviceState at_rest(DeviceState state, uint32_t flags) {
  state.V_BH = {};
  return flagged(state, flags);
}

}  // namespace

HandCurve::HandCurve(std::vector<DeviceState> samples, Resampling resampling, double max_gap)
    : samples_(std::move(samples)),
      resampling_(resampling),
      max_gap_ns_(std::llround(max_gap * 1e9)) {
  HAPTIC_ASSERT(samples_.size() >= 2 && max_gap >= 0);
  HAPTIC_ASSERT(std::adjacent_find(samples_.begin(), samples_.end(),
                                   [](const DeviceState& a, const DeviceState& b) {
                                     return a.t_ns >= b.t_ns;
                                   }) == samples_.end());
  differentiate();
}

DeviceState HandCurve::at(int64_t t_ns) const {
  const auto after =
      std::upper_bound(samples_.begin(), samples_.end(), t_ns,
                       [](int64_t t, const DeviceState& sample) { return t < sample.t_ns; });
  const auto next = static_cast<size_t>(after - samples_.begin());
  if (next < samples_.size() && samples_[next].t_ns - t_ns <= kSnapNs) {
    return flagged(samples_[next], kDeviceFresh);
  }
  if (next == 0) return at_rest(samples_.front(), kDeviceHeld);
  const size_t i = next - 1;
  if (t_ns - samples_[i].t_ns <= kSnapNs) return flagged(samples_[i], kDeviceFresh);
  if (next == samples_.size()) return at_rest(samples_.back(), kDeviceHeld | kDeviceEnded);
  if (is_hole(i)) return at_rest(samples_[i], kDeviceHeld);
  return between(i, t_ns);
}

std::string HandCurve::description() const {
  const double length = 1e-9 * static_cast<double>(samples_.back().t_ns - samples_.front().t_ns);
  const char* how = resampling_ == Resampling::kCubic
                        ? "resampled by cubic and slerp, samples on the grid exact"
                        : "resampled by holding the last sample";
  char text[256];
  std::snprintf(text, sizeof text,
                "open-loop replay: %zu samples, %.1f s, %.1f Hz; %s; %zu holes over %.0f ms held",
                samples_.size(), length, static_cast<double>(samples_.size() - 1) / length, how,
                count_holes(), 1e-6 * static_cast<double>(max_gap_ns_));
  return text;
}

size_t HandCurve::count_holes() const {
  size_t count = 0;
  for (size_t i = 0; i + 1 < samples_.size(); ++i) count += is_hole(i) ? 1 : 0;
  return count;
}

bool HandCurve::is_hole(size_t i) const {
  HAPTIC_ASSERT(i + 1 < samples_.size());
  return samples_[i + 1].t_ns - samples_[i].t_ns > max_gap_ns_;
}

double HandCurve::seconds(size_t i) const {
  return 1e-9 * static_cast<double>(samples_[i + 1].t_ns - samples_[i].t_ns);
}

/// dp/dt at sample i, a knot of the given interval: the slope of the parabola through i and its
/// neighbours, or of the interval's chord if a gap or the end removes a neighbour.
Vec3 HandCurve::slope(size_t i, size_t of_interval) const {
  const auto chord = [&](size_t k) {
    return (samples_[k + 1].X_BH.p - samples_[k].X_BH.p) / seconds(k);
  };
  const bool both = i > 0 && i + 1 < samples_.size() && !is_hole(i - 1) && !is_hole(i);
  if (!both) return chord(of_interval);
  const double before = seconds(i - 1), after = seconds(i);
  return (after * chord(i - 1) + before * chord(i)) / (before + after);
}

DeviceState HandCurve::between(size_t i, int64_t t_ns) const {
  HAPTIC_ASSERT(i + 1 < samples_.size());
  HAPTIC_ASSERT(samples_[i].t_ns <= t_ns && t_ns <= samples_[i + 1].t_ns);
  const DeviceState& a = samples_[i];
  const DeviceState& b = samples_[i + 1];
  if (resampling_ == Resampling::kHold) return flagged(a, kDeviceFresh);
  const double h = seconds(i);
  const double s = 1e-9 * static_cast<double>(t_ns - a.t_ns) / h;
  const Vec3 step = b.X_BH.p - a.X_BH.p;
  const Vec3 from = h * slope(i, i), to = h * slope(i + 1, i);

  DeviceState state = a;
  state.t_ns = t_ns;
  // this form of the Hermite cubic is exact for equal end points
  const double s2 = s * s, r = 1 - s;
  state.X_BH.p = a.X_BH.p + s2 * (3 - 2 * s) * step + s * r * r * from - s2 * r * to;
  state.V_BH.v = (6 * s * r * step + r * (1 - 3 * s) * from + s * (3 * s - 2) * to) / h;
  const Vec3 turn_H = to_rotation_vector(conjugate(a.X_BH.q) * b.X_BH.q);
  state.X_BH.q = normalized(slerp(a.X_BH.q, b.X_BH.q, s));
  state.V_BH.w = rotate(a.X_BH.q, turn_H) / h;
  state.grip = a.grip + s * (b.grip - a.grip);
  return flagged(state, kDeviceFresh);
}

void HandCurve::differentiate() {
  const auto none = [&](Vec3 Twist::*part) {
    return std::all_of(samples_.begin(), samples_.end(),
                       [&](const DeviceState& sample) { return sample.V_BH.*part == Vec3{}; });
  };
  const bool no_velocity = none(&Twist::v), no_spin = none(&Twist::w);
  const size_t last = samples_.size() - 1;
  for (size_t i = 0; i <= last; ++i) {
    // next to a gap: uses the side that has a neighbour
    const bool left = i > 0 && !is_hole(i - 1), right = i < last && !is_hole(i);
    if (!left && !right) continue;
    const DeviceState& a = samples_[left ? i - 1 : i];
    const DeviceState& b = samples_[right ? i + 1 : i];
    if (no_velocity) samples_[i].V_BH.v = slope(i, right ? i : i - 1);
    if (no_spin) {
      const Vec3 turn_B = to_rotation_vector(b.X_BH.q * conjugate(a.X_BH.q));
      samples_[i].V_BH.w = turn_B / (1e-9 * static_cast<double>(b.t_ns - a.t_ns));
    }
  }
}

}  // namespace haptic
