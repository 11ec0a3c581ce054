// SPDX-License-Identifier: Apache-2.0
#include "clients/library/drawing.h"

#include <cmath>
#include <utility>

#include "proto/math/assert.h"

namespace haptic {
namespace {

bool is_near(const Vec3& p) {
  // also false for NaN
  return std::abs(p.x) <= kFarthestDrawn && std::abs(p.y) <= kFarthestDrawn &&
         std::abs(p.z) <= kFarthestDrawn;
}

/// The part of `all` that is in piece number `piece`, of `most` each.
template <typename T>
std::span<const T> part_of(std::span<const T> all, size_t piece, size_t most) {
  const size_t begin = std::min(all.size(), piece * most);
  return all.subspan(begin, std::min(most, all.size() - begin));
}

template <typename T, typename List>
bool add(const List& from, size_t most, std::vector<T>& to) {
  if (from.size() > most - to.size()) return false;
  if (!std::all_of(from.begin(), from.end(), [](const T& one) { return is_drawable(one); })) {
    return false;
  }
  // once: growing by itself a vector may take twice as much
  if (!from.empty()) to.reserve(most);
  to.insert(to.end(), from.begin(), from.end());
  return true;
}

}  // namespace

bool is_drawable(const DrawnPoint& point) {
  return is_near(point.p_W) && point.radius > 0 && point.radius <= kFarthestDrawn;
}

bool is_drawable(const DrawnLine& line) {
  return is_near(line.from_W) && is_near(line.to_W);
}

void cut_piece(std::span<const DrawnPoint> points, std::span<const DrawnLine> lines, uint32_t piece,
               DrawnPiece& out) {
  out.piece = piece;
  out.n_pieces = pieces_of(points.size(), lines.size());
  HAPTIC_ASSERT(piece < out.n_pieces);
  out.points.assign(part_of(points, piece, kMostPiecePoints));
  out.lines.assign(part_of(lines, piece, kMostPieceLines));
}

bool DrawingPieces::begins(const DrawnPiece& piece, uint64_t generation) {
  const bool is_newer = generation > newest_.generation || piece.drawing > newest_.number;
  if (!is_newer || piece.piece != 0 || piece.n_pieces == 0 || piece.n_pieces > kMostPieces) {
    return false;
  }
  collected_.generation = generation;
  collected_.number = piece.drawing;
  collected_.t_ns = piece.t_ns;
  collected_.points.clear();
  collected_.lines.clear();
  n_pieces_ = piece.n_pieces;
  next_ = 0;
  return true;
}

bool DrawingPieces::goes_on(const DrawnPiece& piece, uint64_t generation) const {
  return n_pieces_ > 0 && collected_.generation == generation &&
         collected_.number == piece.drawing && piece.n_pieces == n_pieces_ && piece.piece == next_;
}

bool DrawingPieces::take(const DrawnPiece& piece, uint64_t generation) {
  if (generation < newest_.generation) return false;
  const bool is_next = goes_on(piece, generation) || begins(piece, generation);
  if (!is_next || !add(piece.points, kMostDrawnPoints, collected_.points) ||
      !add(piece.lines, kMostDrawnLines, collected_.lines)) {
    n_pieces_ = 0;
    return false;
  }
  if (++next_ < n_pieces_) return false;
  n_pieces_ = 0;
  // the memory of the one before serves for the next
  std::swap(newest_, collected_);
  return true;
}

bool DrawingReader::read(int most_pieces) {
  bool is_new = false;
  for (int i = 0; i < most_pieces && ring_.next(*piece_); ++i) {
    is_new |= pieces_.take(*piece_, ring_.item_generation());
  }
  return is_new;
}

bool DrawingReader::forget_unless(uint64_t giving) {
  if (newest().generation == giving || newest().generation == 0) return false;
  pieces_.forget();
  return true;
}

}  // namespace haptic
