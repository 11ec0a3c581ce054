// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/restart_policy.h"
#include "proto/math/units.h"

#include <algorithm>
#include <array>

namespace haptic {
namespace {

constexpr int64_t kLatePulseNs = 20 * kMs;  // logged beyond it
constexpr int64_t kHungNs = 250 * kMs;      // killed beyond it
constexpr int64_t kLivedNs = 200 * kMs;     // a shorter life ends by what it does at its start

constexpr int64_t kFirstWaitNs = 1000 * kMs;  // of a spare
constexpr int kMostDoublings = 6;             // to 64 s

}  // namespace

int64_t restart_delay_ns(int deaths_in_a_row, int64_t lived_ns) {
  constexpr std::array kDelays{0 * kMs, 50 * kMs, 200 * kMs, 1000 * kMs};
  const size_t last = kDelays.size() - 1;
  const int64_t delay_ns =
      kDelays[std::min(static_cast<size_t>(std::max(deaths_in_a_row - 1, 0)), last)];
  return lived_ns < kLivedNs ? delay_ns : std::min(delay_ns, lived_ns / 4);
}

int64_t spare_delay_ns(int deaths_in_a_row, int64_t) {
  return kFirstWaitNs << std::clamp(deaths_in_a_row - 1, 0, kMostDoublings);
}

bool runs(const SegmentHeader* header, uint64_t generation) noexcept {
  return header != nullptr && header->generation.load() == generation &&
         header->state.load() == static_cast<uint32_t>(SegmentState::kRun);
}

Pulse judge_pulse(int64_t silent_ns, int64_t period_ns) {
  if (silent_ns > kHungNs + period_ns) return Pulse::kHung;
  return silent_ns > kLatePulseNs + period_ns ? Pulse::kLate : Pulse::kFine;
}

int64_t Silence::look(uint64_t beat, int64_t beat_ns, int64_t t_ns, int64_t held_up_ns) {
  if (beat != beat_) held_up_ns_ = 0;
  beat_ = beat;
  held_up_ns_ += held_up_ns;
  return t_ns - beat_ns - held_up_ns_;
}

}  // namespace haptic
