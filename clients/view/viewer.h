// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "clients/view/foxglove.h"
#include "clients/view/frame.h"
#include "clients/view/log_source.h"
#include "clients/view/web/web.h"

namespace haptic {

inline constexpr int64_t kTickPeriod = 8'333'333;  // [ns]: 120 Hz, the fastest that a page may ask
inline constexpr size_t kMostWaiting = 32;         // messages for one viewer

/// A page or a Foxglove client. There is no queue of frames: the newest is made when the viewer is
/// ready for one.
struct Viewer {
  bool is_foxglove = false;
  FoxgloveClient foxglove;
  std::deque<WebMessage> waiting;  // texts, and the messages of one instant for Foxglove
  bool is_writing = false;
  bool may_control = false;
  int wrong_tokens = 0;
  bool has_shown = true;  // the frame before; of a comparison, those of one instant
  double hz = 60;
  int64_t last_ns = 0;           // of the last frame
  uint64_t sequence = 0;         // of the next
  uint64_t seen = 0;             // samples, and
  uint64_t seen_ticks = 0;       // ticks before this have been sent
  uint64_t seen_drawn = 0;       // View::drawn that it was told of
  std::unique_ptr<LogPage> log;  // of a page that shows a log
};

/// True if its next frame is due: its period is over, give or take half a tick of the bridge.
inline bool is_due(const Viewer& viewer, int64_t now_ns) {
  const int64_t period = static_cast<int64_t>(1e9 / viewer.hz);
  return now_ns - viewer.last_ns >= period - kTickPeriod / 2;
}

/// True if it can be sent one.
inline bool is_ready(const Viewer& viewer) {
  return !viewer.is_writing && viewer.waiting.empty() && viewer.has_shown;
}

/// The frames of one instant. Viewers that have seen the same are sent the same bytes but for the
/// sequence, so that a frame is made once for all of them.
class InstantFrames {
 public:
  explicit InstantFrames(const View& view) : view_(view) {}
  /// The frame for this viewer, and that it has been sent.
  WebMessage next(Viewer& viewer);

 private:
  struct Made {
    FrameOf of;
    SharedText bytes;
  };
  SharedText bytes_of(const FrameOf& of);

  const View& view_;
  std::vector<double> common_;  // made once anybody needs it
  std::vector<Made> made_;
};

/// The frames of what its log page shows, one for each column, and that they have been sent.
std::vector<std::string> next_log_frames(Viewer& viewer, int64_t now_ns);

}  // namespace haptic
