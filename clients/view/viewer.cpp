// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/viewer.h"

#include <algorithm>
#include <cstring>

namespace haptic {

SharedText InstantFrames::bytes_of(const FrameOf& of) {
  const auto same = std::find_if(made_.begin(), made_.end(), [&](const Made& one) {
    return one.of.first_sample == of.first_sample && one.of.unseen == of.unseen;
  });
  if (same != made_.end()) return same->bytes;
  if (common_.empty()) common_ = common_frame(view_);
  return made_.emplace_back(Made{of, shared_text(frame_bytes(common_, view_, of))}).bytes;
}

WebMessage InstantFrames::next(Viewer& viewer) {
  FrameOf of = samples_since(view_.samples, viewer.seen);
  of.sequence = viewer.sequence++;
  const uint64_t passed = view_.ticks - viewer.seen_ticks;
  // the frame itself shows the newest of them; a first frame has passed over nothing
  of.unseen = passed > 0 && of.sequence > 0 ? passed - 1 : 0;
  viewer.seen = of.end_sample;
  viewer.seen_ticks = view_.ticks;
  viewer.last_ns = view_.now_ns;
  viewer.has_shown = false;
  // the sequence is the first number of a frame
  const auto sequence = static_cast<double>(of.sequence);
  WebMessage message{bytes_of(of), false, std::string(sizeof sequence, '\0')};
  std::memcpy(message.own.data(), &sequence, sizeof sequence);
  return message;
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
