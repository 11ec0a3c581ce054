// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "device-io/woodenhaptics/protocol.h"

namespace haptic {

/// Whether the answers of a device are those to what it was asked, where answers have no number.
///
/// It counts lines against answers, one for each. And now and then it asks for a *challenge* before
/// a question: a line that is no command, which an honest firmware answers with the error of that
/// line and of no other (the echo); then it answers the question itself. What comes behind the echo
/// is therefore newer than the challenge. A firmware that repeats itself never sends the echo, one
/// whose answers wait in a queue sends it too late, and one that says more than it is asked is seen
/// by the count. The spacing of the challenges changes, so that no constant delay fits it, and as
/// long as the answers do not match they are of another kind: no echo of before passes for theirs.
///
/// Nothing here depends on where the handle is: a clamped handle answers its challenges.
class AnswerMatch {
 public:
  /// A line is about to be sent: what goes before it. A challenge is due after so many questions,
  /// and as long as the answers do not match; `may` is false where a bare line has to go.
  Challenge ask(bool may) noexcept;

  /// Takes the error of an answer, in the order of arrival. True where it is the echo: what came
  /// before it is too old to be used. `excused`: somebody else may have asked (hapticd lets go of
  /// the device when the servo was held up), so a surplus says nothing about the device.
  bool hear(int32_t error, bool excused) noexcept;

  /// Whether the last answer was one to the last question. Not: after a surplus or a challenge that
  /// was answered as if it were none, until the next echo.
  bool is_settled() const noexcept { return settled_; }

  /// A challenge is under way.
  bool awaits_echo() const noexcept { return echo_ != Challenge::kNone; }

  /// Eight surplus answers, or two challenges that were the only lines under way and were answered
  /// as if they were none, with few answers in between that match; until many have matched.
  bool is_distrusted() const noexcept { return distrusted_; }

  static constexpr int kFewestApart = 16, kMostApart = 31;  // questions from echo to challenge

 private:
  int draw_apart() noexcept;
  void doubt(int weight) noexcept;

  Challenge echo_ = Challenge::kNone;  // expected
  bool alone_ = false;                 // nothing else was under way with the challenge
  int owed_ = 0;                       // answers that may still come
  int ahead_ = 0;                      // of them before the echo
  int behind_ = 0;                     // and behind it
  int asked_ = 0;                      // questions since the last echo
  int apart_ = kMostApart;             // until the next challenge
  int doubt_ = 0;                      // shrinks by one with each answer that matches
  bool settled_ = true, distrusted_ = false;
  uint32_t random_ = 1;
};

}  // namespace haptic
