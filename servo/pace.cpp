// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/pace.h"

namespace haptic {
namespace {

constexpr double kMostLate = 0.01;            // share of ticks
constexpr double kLeastRate = 0.9;            // share of frames
constexpr int64_t kJudgedNs = 1'000'000'000;  // [ns]; shorter, a single stall would be a verdict

uint32_t judge(const Pace& pace, const ServoInput& input, double sim_period) {
  uint32_t flags = 0;
  const uint64_t skipped = input.skipped - pace.skipped;
  const auto ticks = static_cast<double>(pace.n_ticks);
  const auto missed = static_cast<double>(skipped);
  if (missed > kMostLate * (ticks + missed)) flags |= kServoLate;
  if (static_cast<double>(pace.n_late_contacts) > kMostLate * ticks) flags |= kServoContactLate;
  const uint64_t seq = input.scene != nullptr ? input.scene->seq : 0;
  // a sim that does not run is said elsewhere, and one that began anew counts anew
  if (pace.scene_seq > 0 && seq > pace.scene_seq) {
    const double seconds = 1e-9 * static_cast<double>(input.t_ns - pace.since_ns);
    if (static_cast<double>(seq - pace.scene_seq) * sim_period < kLeastRate * seconds) {
      flags |= kServoSimLate;
    }
  }
  return flags;
}

}  // namespace

uint32_t keep_pace(Pace& pace, const ServoInput& input, uint32_t age_flags, double sim_period) {
  const bool begins = pace.n_ticks == 0 && pace.since_ns == 0;
  if (begins || input.t_ns - pace.since_ns >= kJudgedNs) {
    const uint32_t flags = begins ? 0 : judge(pace, input, sim_period);
    pace = {input.t_ns, input.skipped, input.scene != nullptr ? input.scene->seq : 0, 0, 0, flags};
  }
  ++pace.n_ticks;
  pace.n_late_contacts += (age_flags & (kServoHolding | kServoFading | kServoStale)) != 0;
  return pace.flags;
}

}  // namespace haptic
