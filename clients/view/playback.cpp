// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/playback.h"

#include <algorithm>
#include <cmath>

namespace haptic {

void Playback::take(const StepMessage& step) {
  speed_ = 0;
  tick_ = std::max(std::floor(tick_) + static_cast<double>(step.ticks), 0.0);
}

uint64_t Playback::at(int64_t now_ns, const LogTicks& log) {
  const double seconds = 1e-9 * static_cast<double>(now_ns - then_ns_);
  then_ns_ = now_ns;
  if (speed_ > 0) {
    tick_ += seconds * log.rate * speed_;
    const bool is_beyond = loop_ && tick_ > static_cast<double>(loop_->second);
    if (is_beyond) tick_ = static_cast<double>(loop_->first);
  }
  tick_ = std::clamp(tick_, static_cast<double>(log.first), static_cast<double>(log.last));
  return static_cast<uint64_t>(tick_);
}

}  // namespace haptic
