// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/viewer.h"

namespace haptic {

std::string next_frame(Viewer& viewer, const std::vector<double>& common, const View& view) {
  FrameOf of = samples_since(view.samples, viewer.seen);
  of.sequence = viewer.sequence++;
  const uint64_t passed = view.ticks - viewer.seen_ticks;
  // the frame itself shows the newest of them; a first frame has passed over nothing
  of.unseen = passed > 0 && of.sequence > 0 ? passed - 1 : 0;
  viewer.seen = of.end_sample;
  viewer.seen_ticks = view.ticks;
  viewer.last_ns = view.now_ns;
  viewer.has_shown = false;
  return frame_bytes(common, view, of);
}

std::vector<std::string> next_log_frames(Viewer& viewer, int64_t now_ns) {
  std::vector<std::string> frames;
  for (size_t i = 0; i < viewer.log->columns.size(); ++i) {
    const LogPage::Column& column = *viewer.log->columns[i];
    if (!column.view.has_servo) continue;
    FrameOf of = samples_since(column.view.samples, column.first_new);
    of.sequence = viewer.sequence++;
    of.column = i;
    of.unseen = viewer.log->unseen;
    frames.push_back(frame_bytes(common_frame(column.view), column.view, of));
  }
  viewer.last_ns = now_ns;
  viewer.has_shown = frames.empty();
  return frames;
}

}  // namespace haptic
