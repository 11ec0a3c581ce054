// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "proto/ipc/ring_source.h"

/// A drawing of a client (docs/clients-that-give.md#draw), cut into the pieces of its ring and put
/// together again. In: points and lines; pieces of a ring that anybody may have written. The pieces
/// of a drawing are numbered from 0 and follow each other, so a reader takes piece 0 of a drawing
/// that is newer than all it has had, then only the next piece of the same drawing. Any other
/// piece, and one with a number that no viewer could show, ends the collection; the next begins
/// with a piece 0. When the last piece is there, the drawing replaces the one before it. So
/// whatever the ring holds, a drawing is shown as a whole or not at all, and a reader holds two
/// drawings of at most kMostDrawnPoints points and kMostDrawnLines lines. A writer that begins anew
/// (another generation) counts anew.
namespace haptic {

inline constexpr size_t kMostDrawnPoints = 200'000;
inline constexpr size_t kMostDrawnLines = 20'000;
/// Largest coordinate and radius [m]: a viewer leads no hand farther.
inline constexpr double kFarthestDrawn = 1e3;

/// True if viewers can show it: all numbers are finite, and none is beyond kFarthestDrawn; a radius
/// is above 0.
bool is_drawable(const DrawnPoint& point);
bool is_drawable(const DrawnLine& line);

/// Pieces of a drawing; an empty one, which shows nothing, has one piece.
constexpr uint32_t pieces_of(size_t n_points, size_t n_lines) {
  const size_t by_points = (n_points + kMostPiecePoints - 1) / kMostPiecePoints;
  const size_t by_lines = (n_lines + kMostPieceLines - 1) / kMostPieceLines;
  return static_cast<uint32_t>(std::max({by_points, by_lines, size_t{1}}));
}
/// Most pieces of a drawing: another writer may put points and lines into different ones.
inline constexpr uint32_t kMostPieces =
    pieces_of(kMostDrawnPoints, 0) + pieces_of(0, kMostDrawnLines);

/// Fills in piece `piece` of a drawing; `seq`, `drawing` and `t_ns` stay.
void cut_piece(std::span<const DrawnPoint> points, std::span<const DrawnLine> lines, uint32_t piece,
               DrawnPiece& out);

/// A drawing of a client, as viewers show it.
struct Drawing {
  uint64_t generation = 0;  // of its segment; 0: there is no drawing
  uint64_t number = 0;
  int64_t t_ns = 0;  // when it was made, CLOCK_MONOTONIC
  std::vector<DrawnPoint> points;
  std::vector<DrawnLine> lines;
};

/// Puts drawings together.
class DrawingPieces {
 public:
  /// Takes a piece of the segment of this generation; true: newest() is another one now.
  bool take(const DrawnPiece& piece, uint64_t generation);
  const Drawing& newest() const { return newest_; }
  void forget() { *this = {}; }

 private:
  bool begins(const DrawnPiece& piece, uint64_t generation);
  bool goes_on(const DrawnPiece& piece, uint64_t generation) const;

  Drawing newest_, collected_;
  uint32_t next_ = 0, n_pieces_ = 0;  // of what is collected; n_pieces_ 0: nothing is
};

/// The drawings of a client, for viewers.
class DrawingReader {
 public:
  using Ring = RingSource<&DrawChannels::pieces>;
  /// Takes client.ring<&DrawChannels::pieces>(Start::kOldest, number).
  explicit DrawingReader(Ring ring) : ring_(ring) {}

  /// Reads at most so many pieces; true: newest() is another one now.
  bool read(int most_pieces);
  /// Forgets the drawing of who has left; true: there was one. `giving` is that of this client in a
  /// ControlFrame that was read after the pieces.
  bool forget_unless(uint64_t giving);
  const Drawing& newest() const { return pieces_.newest(); }

 private:
  Ring ring_;
  DrawingPieces pieces_;
  std::unique_ptr<DrawnPiece> piece_ = std::make_unique<DrawnPiece>();
};

}  // namespace haptic
