// SPDX-License-Identifier: Apache-2.0
#include "clients/library/drawer.h"

#include "proto/os/message.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr size_t kManyPoints = 20'000, kManyLines = 2'000;  // above which a drawing is large
constexpr int64_t kPeriodNs = kNsPerSecond / 60;            // as often as a page shows
constexpr int64_t kLargePeriodNs = kNsPerSecond / 5;        // 9 MB each: 46 MB/s in the ring

template <typename T>
void check(std::span<const T> all, size_t most, const char* what, const char* wanted) {
  if (all.size() > most) {
    throw MessageError("a drawing of " + std::to_string(all.size()) + " " + what + "s; at most " +
                       std::to_string(most) + " are shown: leave some out");
  }
  const auto wrong =
      std::find_if_not(all.begin(), all.end(), [](const T& one) { return is_drawable(one); });
  if (wrong == all.end()) return;
  throw MessageError(std::string(what) + " " + std::to_string(wrong - all.begin()) +
                     " of a drawing cannot be shown; " + wanted);
}

}  // namespace

bool DrawingRate::take(int64_t t_ns, size_t n_points, size_t n_lines) {
  if (t_ns < due_ns_ - period_ns_ / 2) return false;
  period_ns_ = n_points > kManyPoints || n_lines > kManyLines ? kLargePeriodNs : kPeriodNs;
  due_ns_ = std::max(due_ns_, t_ns) + period_ns_;
  return true;
}

void check_drawing(std::span<const DrawnPoint> points, std::span<const DrawnLine> lines) {
  check(points, kMostDrawnPoints, "point",
        "its place is to be within 1 km, its radius above 0 m and at most 1 km");
  check(lines, kMostDrawnLines, "line", "its ends are to be within 1 km");
}

Drawer::Drawer(const GiveSeat& seat) {
  const GivePlace& place = seat.place;
  if ((place.may & kMayDraw) == 0) {
    throw HandoutError("this client may not draw; add \"draw\" to may of its [[client]]");
  }
  segment_ = std::make_unique<SegmentWriter<DrawChannels>>(place.generation, place.client);
  offer_to_give(seat, segment_spec<DrawChannels>(place.client), segment_->fd());
  segment_->set_state(SegmentState::kRun);
}

bool Drawer::draw(std::span<const DrawnPoint> points, std::span<const DrawnLine> lines) {
  check_drawing(points, lines);
  const int64_t t_ns = now_ns();
  if (!rate_.take(t_ns, points.size(), lines.size())) return false;
  DrawnPiece& piece = *piece_;
  ++piece.drawing;
  piece.t_ns = t_ns;
  for (uint32_t i = 0; i < pieces_of(points.size(), lines.size()); ++i) {
    cut_piece(points, lines, i, piece);
    ++piece.seq;
    segment_->channels().pieces.publish(piece);
  }
  segment_->beat(piece.drawing, t_ns);
  return true;
}

}  // namespace haptic
