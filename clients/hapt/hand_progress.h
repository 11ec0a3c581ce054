// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "clients/report/summary.h"
#include "proto/os/realtime.h"

namespace haptic {

/// Shows what the hand did while a session runs: the share of ticks in contact, the largest force,
/// the late ticks. Elsewhere than on a terminal it is a line every five seconds, about the time
/// since the last line. On a terminal one line overwrites itself four times a second; the share is
/// then of the time since the start.
class HandProgress {
 public:
  explicit HandProgress(double total) : total_(total), terminal_(isatty(STDERR_FILENO) == 1) {}
  ~HandProgress() {
    if (terminal_ && shown_) std::fputs("\r\033[K", stderr);
  }
  HandProgress(const HandProgress&) = delete;

  /// Takes one frame after the other.
  void add(const ServoFrame& frame) {
    ++ticks_;
    touching_ += is_touching(frame);
    largest_ = std::max(largest_, norm(frame.F_device_B.f));
    late_ = frame.skipped;
  }

  /// Writes the line when it is due, `seconds` after the first frame.
  void show(double seconds, int64_t t_ns) {
    if (t_ns - last_ns_ < (terminal_ ? kNsPerSecond / 4 : 5 * kNsPerSecond)) return;
    last_ns_ = t_ns;
    shown_ = true;
    const double share = static_cast<double>(touching_) / static_cast<double>(std::max(ticks_, 1L));
    std::fprintf(stderr,
                 "%s%5.1f of %.0f s   %3ld %% in contact   force up to %4.1f N   late ticks %llu%s",
                 terminal_ ? "\r" : "", seconds, total_, std::lround(100 * share), largest_,
                 static_cast<unsigned long long>(late_), terminal_ ? "\033[K" : "\n");
    largest_ = 0;
    if (!terminal_) ticks_ = touching_ = 0;
  }

 private:
  double total_;
  bool terminal_, shown_ = false;
  int64_t ticks_ = 0, touching_ = 0;
  double largest_ = 0;  // force [N], since the last line
  uint64_t late_ = 0;   // ticks, since the start
  int64_t last_ns_ = now_ns();
};

}  // namespace haptic
