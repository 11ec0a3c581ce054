// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "device-io/sensing/trust.h"
#include "device-io/woodenhaptics/protocol.h"

namespace haptic {

/// Checks that a device's answers belong to the questions, where answers carry no number.
///
/// Counts lines against answers, one for each. From time to time it precedes a question with a
/// *challenge*: an invalid line, which an honest firmware answers with the error of exactly that
/// line (the echo) before it answers the question. Answers after the echo are therefore newer than
/// the challenge. A firmware that repeats itself never sends the echo, one with a queue of answers
/// sends it too late, and one with surplus answers is caught by the count. The spacing of the
/// challenges varies, so that no constant delay fits it. While answers do not match, challenges are
/// of the other kind, so that no earlier echo passes for theirs.
///
/// Nothing here depends on the handle's motion: a clamped handle answers its challenges.
class AnswerMatch {
 public:
  /// To be called before each question; returns the challenge to precede it. One is due after a
  /// varying number of questions, and while the answers do not match; `may` = false suppresses it.
  Challenge ask(bool may) noexcept;

  /// Takes the error of an answer, in order of arrival. True for the echo: what came before it is
  /// too old to be used. `excused`: somebody else may have asked (hapticd releases the device if
  /// the servo is held up), so a surplus is no evidence against the device.
  bool hear(int32_t error, bool excused) noexcept;

  /// True if the last answer belongs to the last question. False after a surplus or a challenge
  /// without echo, until the next echo.
  bool is_settled() const noexcept { return settled_; }

  /// A challenge is under way.
  bool awaits_echo() const noexcept { return echo_ != Challenge::kNone; }

  /// Set by eight surplus answers, or two challenges without echo that were the only lines under
  /// way, with few matching answers in between; cleared by many matching answers.
  bool is_distrusted() const noexcept { return trust_.is_lost(); }

  static constexpr int kFewestApart = 16, kMostApart = 31;  // questions from echo to challenge
  static constexpr int kMostDoubt = 400;                    // matching answers that win trust back

 private:
  int draw_apart() noexcept;

  Challenge echo_ = Challenge::kNone;  // expected
  bool alone_ = false;                 // no other line was under way with the challenge
  int owed_ = 0;                       // answers still expected
  int ahead_ = 0;                      // of them, before the echo
  int behind_ = 0;                     // of them, after the echo
  int asked_ = 0;                      // since the last echo
  int apart_ = kMostApart;             // questions until the next challenge
  Trust trust_{kMostDoubt};
  bool settled_ = true;
  uint32_t random_ = 1;
};

}  // namespace haptic
