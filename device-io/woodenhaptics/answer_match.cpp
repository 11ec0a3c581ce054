// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/answer_match.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kMostOwed = 1000;  // bound for a device that never answers

// Doubt, in matching answers that make up for it. A surplus: a delayed session may cause a few per
// second, old answers between new ones cause eight within 40 ms. A challenge that fails alone has
// no honest cause; two of them, even at the longest spacing, are enough.
constexpr int kDoubtOfSurplus = AnswerMatch::kMostDoubt / 8;
constexpr int kDoubtOfFailure = (AnswerMatch::kMostDoubt + AnswerMatch::kMostApart + 2) / 2;

}  // namespace

/// Marsaglia's xorshift, 32 bits.
int AnswerMatch::draw_apart() noexcept {
  random_ ^= random_ << 13;
  random_ ^= random_ >> 17;
  random_ ^= random_ << 5;
  return kFewestApart + static_cast<int>(random_ % (kMostApart - kFewestApart + 1));
}

Challenge AnswerMatch::ask(bool may) noexcept {
  ++asked_;
  // asked again before the echo, which may still come, with one more answer behind it
  const bool awaited = awaits_echo();
  alone_ = !awaited && settled_ && owed_ == 0;
  const bool due = !alone_ || asked_ >= apart_;
  const bool challenges = !awaited && may && due;
  if (challenges) {
    echo_ = settled_ ? Challenge::kNotAsMany : Challenge::kNoBegin;
    ahead_ = owed_;
    behind_ = 0;
  }
  behind_ = std::min(behind_ + 1, kMostOwed);
  owed_ = std::min(owed_ + (challenges ? 2 : 1), kMostOwed);
  return challenges ? echo_ : Challenge::kNone;
}

bool AnswerMatch::hear(int32_t error, bool excused) noexcept {
  HAPTIC_ASSERT(owed_ >= 0 && ahead_ >= 0);
  if (awaits_echo() && error == static_cast<int32_t>(echo_)) {
    echo_ = Challenge::kNone;
    settled_ = true;
    owed_ = behind_;
    asked_ = 0;
    apart_ = draw_apart();
    return true;
  }
  const bool surplus = owed_ == 0, failed = awaits_echo() && alone_;
  // only a line after the challenge can have this answer
  const bool jumped = awaits_echo() && ahead_ == 0;
  if (jumped) echo_ = Challenge::kNone;
  ahead_ = std::max(ahead_ - 1, 0);
  owed_ = std::max(owed_ - 1, 0);
  alone_ = false;
  if (settled_ && !surplus && !jumped) {
    trust_.doubt(-1);
    return false;
  }
  if (settled_ && !excused) {
    if (surplus) trust_.doubt(kDoubtOfSurplus);
    if (failed) trust_.doubt(kDoubtOfFailure);
  }
  settled_ = false;
  return false;
}

}  // namespace haptic
