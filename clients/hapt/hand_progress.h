// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <unistd.h>

#include <cstdio>

#include "clients/report/summary.h"
#include "proto/os/realtime.h"

namespace haptic {

/// Names the phase of the hand's motion in one word: it approaches, presses or slides.
inline const char* phase_of(const ServoFrame& frame) {
  constexpr double kSliding = 0.01;  // of the proxy [m/s]
  if (!is_touching(frame)) return "approaches";
  return norm(frame.V_WP.v) > kSliding ? "slides" : "presses";
}

/// Shows the phase, the force and the late ticks while a session runs: on a terminal a line that
/// overwrites itself, elsewhere a line every five seconds.
class HandProgress {
 public:
  explicit HandProgress(double total) : total_(total), terminal_(isatty(STDERR_FILENO) == 1) {}
  ~HandProgress() {
    if (terminal_ && shown_) std::fputs("\r\033[K", stderr);
  }
  HandProgress(const HandProgress&) = delete;

  void show(const ServoFrame& frame, double seconds, int64_t t_ns) {
    if (t_ns - last_ns_ < (terminal_ ? kNsPerSecond / 4 : 5 * kNsPerSecond)) return;
    last_ns_ = t_ns;
    shown_ = true;
    std::fprintf(stderr, "%s%5.1f of %.0f s   the hand %-10s   force %4.1f N   late ticks %llu%s",
                 terminal_ ? "\r" : "", seconds, total_, phase_of(frame), norm(frame.F_device_B.f),
                 static_cast<unsigned long long>(frame.skipped), terminal_ ? "\033[K" : "\n");
  }

 private:
  double total_;
  bool terminal_, shown_ = false;
  int64_t last_ns_ = now_ns();
};

}  // namespace haptic
