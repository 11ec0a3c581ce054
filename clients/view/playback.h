// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "clients/view/page_message.h"

namespace haptic {

/// The ticks that a log has, and their rate [Hz].
struct LogTicks {
  uint64_t first = 0, last = 0;
  double rate = 1000;
};

/// The place of a page in a log: the state of its slider, as a function of the time that is given.
class Playback {
 public:
  explicit Playback(uint64_t tick) : tick_(static_cast<double>(tick)) {}

  /// Carries out a page's request; `now_ns` as in at(). NextMessage is for who knows the marks.
  void take(const SeekMessage& seek) { tick_ = static_cast<double>(seek.tick); }
  void take(const PlayMessage& play) { speed_ = play.speed; }
  void take(const StopMessage&) { speed_ = 0; }
  void take(const StepMessage& step);
  void take(const LoopMessage& loop) { loop_ = loop.ticks; }

  /// The tick at this instant; between the first and the last. At the end of a loop it begins
  /// anew; at the end of the log it waits there, and goes on when there is more.
  uint64_t at(int64_t now_ns, const LogTicks& log);

 private:
  double tick_;
  double speed_ = 0;  // 0: stands still
  std::optional<std::pair<uint64_t, uint64_t>> loop_;
  int64_t then_ns_ = 0;
};

}  // namespace haptic
