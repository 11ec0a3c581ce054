// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/sensing/encoder_noise.h"

#include <algorithm>
#include <cstdlib>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kRounding = 1;  // quantisation of the steps [counts]

}  // namespace

bool EncoderNoise::turns_too_fast(size_t i, int32_t count, int64_t asked_ns, int64_t heard_ns) {
  Change& last = last_[i];
  const int32_t step = count - last.count;
  if (step == 0) return false;
  const int64_t took_ns = heard_ns - last.asked_ns;
  const bool turns = last.step != 0 && (step > 0) != (last.step > 0);
  const double back = std::min(std::abs(step), std::abs(last.step));
  const double most = kRounding + most_acceleration_[i] / 2 * static_cast<double>(took_ns) *
                                      static_cast<double>(last.took_ns);
  last = {count, step, asked_ns, took_ns};
  return turns && back > most;
}

void EncoderNoise::add(const MotorCounts& counts, int64_t asked_ns, int64_t heard_ns) noexcept {
  HAPTIC_ASSERT(asked_ns <= heard_ns);
  bool implausible = false;
  for (size_t i = 0; i < last_.size(); ++i) {
    if (!started_) last_[i] = {counts[i], 0, asked_ns, 0};
    implausible |= turns_too_fast(i, counts[i], asked_ns, heard_ns);
  }
  started_ = true;
  trust_.judge(!implausible);
}

}  // namespace haptic
