// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/pushes/push_history.h"

#include <algorithm>

#include "sim/pushes/hand_pushes.h"

namespace haptic {

PushHistory::PushHistory(size_t n_objects, size_t first_response)
    : n_objects_(n_objects),
      first_response_(first_response),
      frames_(n_objects > 0 ? kMost : 0),
      pushes_(kMost * n_objects) {}

void PushHistory::add(const ServoFrame& frame) {
  if (n_objects_ == 0 || frame.t_ns == 0 || !has_finite_counters(frame)) return;
  const bool is_same_servo = size_ > 0 && frame.impulses_since_ns == since_ns_;
  const uint64_t last = size_ > 0 ? frames_[(end_ - 1) % kMost].tick : 0;
  if (is_same_servo && frame.tick == last) return;
  const bool goes_on = is_same_servo && frame.tick > last;
  if (!goes_on) size_ = 0;
  since_ns_ = frame.impulses_since_ns;
  frames_[end_ % kMost] = {frame.tick, frame.t_ns};
  for (size_t k = 0; k < n_objects_; ++k) {
    const size_t response = first_response_ + k;
    pushes_[end_ % kMost * n_objects_ + k] =
        response < frame.pushes.size() ? frame.pushes[response] : ObjectPush{};
  }
  ++end_;
  size_ = std::min<uint64_t>(size_ + 1, kMost);
}

std::optional<uint64_t> PushHistory::find(uint64_t tick) const {
  uint64_t low = begin(), high = end_;
  while (low < high) {
    const uint64_t middle = low + (high - low) / 2;
    frames_[middle % kMost].tick < tick ? low = middle + 1 : high = middle;
  }
  if (low == end_ || frames_[low % kMost].tick != tick) return std::nullopt;
  return low;
}

}  // namespace haptic
