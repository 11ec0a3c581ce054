// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "clients/library/drawing.h"
#include "proto/ipc/give_message.h"

namespace haptic {

/// How often a client may draw: at most 60 times a second, five times where a drawing has more than
/// 20,000 points or 2,000 lines. One that keeps the rate on the average may be half a period early.
class DrawingRate {
 public:
  /// True: a drawing of that many may be shown now.
  bool take(int64_t t_ns, size_t n_points, size_t n_lines);

 private:
  int64_t due_ns_ = 0, period_ns_ = 0;  // of the next drawing, and since the last
};

/// Shows points and lines to viewers, under a name whose [[client]] may draw.
///
///   Giver giver(client, "give", "ball");
///   Drawer drawer(giver.seat());
///   …
///   drawer.draw(points, lines);
///
/// A drawing replaces the one before, and an empty one shows nothing. What is shown goes when the
/// place is given up.
class Drawer {
 public:
  /// Makes a segment of 28 MB and offers it. Throws HandoutError with a remedy, SegmentError.
  explicit Drawer(const GiveSeat& seat);

  /// False: the last one is shown for too short a time yet, and nothing was done. Throws
  /// MessageError: too many, or a number that no viewer can show.
  bool draw(std::span<const DrawnPoint> points, std::span<const DrawnLine> lines = {});

 private:
  std::unique_ptr<SegmentWriter<DrawChannels>> segment_;
  std::unique_ptr<DrawnPiece> piece_ = std::make_unique<DrawnPiece>();
  DrawingRate rate_;
};

/// Throws MessageError: a drawing has too many points or lines, or one that no viewer can show.
void check_drawing(std::span<const DrawnPoint> points, std::span<const DrawnLine> lines);

}  // namespace haptic
