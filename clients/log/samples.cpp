// SPDX-License-Identifier: Apache-2.0
#include "clients/log/samples.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr uint64_t kRateSpan = 100;  // samples of contact_rate: 0.1 s at 1 kHz

}  // namespace

void Samples::add(Sample sample) {
  if (end_ > 0) {
    const Sample& before = at(end_ - std::min(end_, kRateSpan));
    const double seconds = sample.time - before.time;
    // a new contact process counts from the beginning
    const bool counts = seconds > 0 && sample.contact_seq >= before.contact_seq;
    sample.contact_rate =
        counts ? static_cast<double>(sample.contact_seq - before.contact_seq) / seconds : 0;
  }
  ring_[end_ % kCapacity] = sample;
  ++end_;
}

Sample sample_of(const ServoFrame& frame, const Pose& X_WB) {
  return {.time = 1e-9 * static_cast<double>(frame.t_ns),
          .force_W = rotate(X_WB.q, frame.F_device_B.f),
          .torque_W = rotate(X_WB.q, frame.F_device_B.t),
          .depth = frame.depth,
          .wake_late = 1e-9 * static_cast<double>(frame.wake_late_ns),
          .flags = frame.flags,
          .contact_seq = frame.contact_seq};
}

}  // namespace haptic
