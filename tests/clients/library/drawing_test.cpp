// SPDX-License-Identifier: GPL-3.0-or-later
// Drawings: what a client publishes in pieces is shown as a whole or not at all, whatever the ring
// holds. A point of these drawings says of which drawing it is and which of its points.
#include "clients/library/drawing.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>

#include "clients/library/drawer.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

struct Sizes {
  size_t points = 0, lines = 0;
};

std::vector<DrawnPoint> points_of(uint64_t drawing, size_t n) {
  std::vector<DrawnPoint> points(n);
  for (size_t i = 0; i < n; ++i) {
    // both are exact in a double; the drawing is in millimetres, to be within the bound
    points[i].p_W = {1e-3 * static_cast<double>(drawing), 0, 0};
    points[i].radius = 1e-3;
    points[i].colour = static_cast<uint32_t>(i);
  }
  return points;
}

std::vector<DrawnLine> lines_of(uint64_t drawing, size_t n) {
  std::vector<DrawnLine> lines(n);
  for (size_t i = 0; i < n; ++i) {
    lines[i].to_W = {0, 1e-3 * static_cast<double>(drawing), 0};
    lines[i].colour = static_cast<uint32_t>(i);
  }
  return lines;
}

/// Whether it is drawing `number` with as many points and lines, each in its place.
bool is_whole(const Drawing& drawing, uint64_t number, Sizes wanted) {
  if (drawing.number != number || drawing.points.size() != wanted.points ||
      drawing.lines.size() != wanted.lines) {
    return false;
  }
  const double place = 1e-3 * static_cast<double>(number);
  for (size_t i = 0; i < wanted.points; ++i) {
    const DrawnPoint& point = drawing.points[i];
    if (point.p_W.x != place || point.radius != 1e-3 || point.colour != i) return false;
  }
  for (size_t i = 0; i < wanted.lines; ++i) {
    const DrawnLine& line = drawing.lines[i];
    if (line.to_W.y != place || line.colour != i) return false;
  }
  return true;
}

/// The pieces as this file cuts them, which shares nothing with the library.
std::vector<DrawnPiece> cut(uint64_t drawing, Sizes sizes) {
  const auto points = points_of(drawing, sizes.points);
  const auto lines = lines_of(drawing, sizes.lines);
  std::vector<DrawnPiece> pieces;
  size_t p = 0, l = 0;
  do {
    auto& piece = pieces.emplace_back();
    piece.drawing = drawing;
    piece.piece = static_cast<uint32_t>(pieces.size() - 1);
    for (; p < points.size() && !piece.points.full(); ++p) piece.points.push_back(points[p]);
    for (; l < lines.size() && !piece.lines.full(); ++l) piece.lines.push_back(lines[l]);
  } while (p < points.size() || l < lines.size());
  for (auto& piece : pieces) piece.n_pieces = static_cast<uint32_t>(pieces.size());
  return pieces;
}

/// The rings of clients that come one after the other, as a viewer has them mapped.
class Rings {
 public:
  Rings() { list_.push_back(std::make_unique<detail::Generation>()); }

  DrawChannels& begin(uint64_t generation) {
    writers_.push_back(std::make_unique<SegmentWriter<DrawChannels>>(generation, 3));
    auto next = std::make_unique<detail::Generation>();
    next->mapping = std::make_unique<SegmentMapping>(reopen_read_only(writers_.back()->fd()),
                                                     segment_spec<DrawChannels>(3));
    next->serial = list_.size();
    list_.back()->next = next.get();
    list_.push_back(std::move(next));
    return writers_.back()->channels();
  }
  DrawingReader reader() {
    const Source<DrawChannels> source(list_.front().get(), &mark_);
    return DrawingReader(DrawingReader::Ring(source, Start::kOldest));
  }

 private:
  std::vector<std::unique_ptr<SegmentWriter<DrawChannels>>> writers_;
  std::vector<std::unique_ptr<detail::Generation>> list_;
  detail::ReaderMark mark_;
};

/// Publishes as the library cuts it.
void publish_cut(DrawChannels& channels, uint64_t drawing, Sizes sizes) {
  const auto points = points_of(drawing, sizes.points);
  const auto lines = lines_of(drawing, sizes.lines);
  const auto piece = std::make_unique<DrawnPiece>();
  piece->drawing = drawing;
  for (uint32_t i = 0; i < pieces_of(points.size(), lines.size()); ++i) {
    cut_piece(points, lines, i, *piece);
    channels.pieces.publish(*piece);
  }
}

constexpr Sizes kSizes[] = {{0, 0},   {1, 0},    {0, 1},    {2048, 512},       {2049, 0},
                            {0, 513}, {5000, 2}, {3, 1500}, {200'000, 20'000}, {20'000, 2'000},
                            {0, 0}};

/// More pieces than a ring has.
constexpr int kAll = 1000;

}  // namespace

TEST_CASE("drawing: what is published in pieces is read as it was") {
  Rings rings;
  DrawingReader reader = rings.reader();
  CHECK_FALSE(reader.read(kAll));
  DrawChannels& channels = rings.begin(1);
  uint64_t number = 0;
  for (const Sizes& sizes : kSizes) {
    publish_cut(channels, ++number, sizes);
    CHECK(reader.read(kAll));
    CHECK(reader.newest().generation == 1);
    CHECK(is_whole(reader.newest(), number, sizes));
    CHECK_FALSE(reader.read(kAll));
  }
}

TEST_CASE("drawing: a viewer that comes late, or falls behind, shows the newest") {
  Rings rings;
  DrawChannels& channels = rings.begin(1);
  for (uint64_t number = 1; number <= 4; ++number) publish_cut(channels, number, {200'000, 20'000});
  DrawingReader late = rings.reader();
  CHECK(late.read(kAll));
  CHECK(is_whole(late.newest(), 4, {200'000, 20'000}));
  for (uint64_t number = 5; number <= 9; ++number) publish_cut(channels, number, {190'000, 7});
  // a few pieces at a time
  while (late.newest().number != 9) {
    const uint64_t before = late.newest().number;
    if (!late.read(10)) continue;
    CHECK(late.newest().number > before);
    CHECK(is_whole(late.newest(), late.newest().number, {190'000, 7}));
  }
}

TEST_CASE("drawing: the next client begins anew, and who leaves takes its drawing along") {
  Rings rings;
  DrawingReader reader = rings.reader();
  publish_cut(rings.begin(4), 70, {10, 10});
  CHECK(reader.read(kAll));
  CHECK_FALSE(reader.forget_unless(4));
  CHECK(is_whole(reader.newest(), 70, {10, 10}));
  CHECK(reader.forget_unless(0));
  CHECK(reader.newest().points.empty());
  CHECK(reader.newest().generation == 0);
  CHECK_FALSE(reader.forget_unless(0));
  publish_cut(rings.begin(5), 1, {3000, 0});
  CHECK(reader.read(kAll));
  CHECK(is_whole(reader.newest(), 1, {3000, 0}));
  CHECK(reader.forget_unless(6));
}

TEST_CASE("drawing: half a drawing of a client that was replaced is never shown") {
  DrawingPieces pieces;
  const auto old = cut(8, {5000, 0}), next = cut(8, {5000, 0});
  CHECK_FALSE(pieces.take(old[0], 1));
  CHECK_FALSE(pieces.take(next[1], 2));
  CHECK_FALSE(pieces.take(next[2], 2));
  CHECK(pieces.newest().generation == 0);
  for (const auto& piece : next) pieces.take(piece, 2);
  CHECK(is_whole(pieces.newest(), 8, {5000, 0}));
  CHECK(pieces.newest().generation == 2);
  // an older client, and drawings that go back
  for (const auto& piece : cut(9, {5, 0})) CHECK_FALSE(pieces.take(piece, 1));
  for (const auto& piece : cut(8, {5, 0})) CHECK_FALSE(pieces.take(piece, 2));
  for (const auto& piece : cut(7, {5, 0})) CHECK_FALSE(pieces.take(piece, 2));
  CHECK(is_whole(pieces.newest(), 8, {5000, 0}));
}

namespace {

using Spoil = void (*)(DrawnPiece&, std::mt19937_64&);
template <typename List>
auto& any_of(List& list, std::mt19937_64& random) {
  return list[random() % list.size()];
}
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kEndless = std::numeric_limits<double>::infinity();

/// Each makes a piece of which nothing may be seen; a piece has points and lines.
constexpr Spoil kSpoils[] = {
    [](DrawnPiece& p, std::mt19937_64& r) { any_of(p.points, r).p_W.y = kNone; },
    [](DrawnPiece& p, std::mt19937_64& r) { any_of(p.points, r).p_W.z = -kEndless; },
    [](DrawnPiece& p, std::mt19937_64& r) { any_of(p.points, r).p_W.x = 1e4; },
    [](DrawnPiece& p, std::mt19937_64& r) { any_of(p.points, r).radius = 1e300; },
    [](DrawnPiece& p, std::mt19937_64& r) { any_of(p.points, r).radius = kNone; },
    [](DrawnPiece& p, std::mt19937_64& r) { any_of(p.points, r).radius = 0; },
    [](DrawnPiece& p, std::mt19937_64& r) { any_of(p.points, r).radius = -1; },
    [](DrawnPiece& p, std::mt19937_64& r) { any_of(p.lines, r).from_W.x = kNone; },
    [](DrawnPiece& p, std::mt19937_64& r) { any_of(p.lines, r).to_W.z = 2e3; },
    [](DrawnPiece& p, std::mt19937_64&) { p.n_pieces += 1; },
    [](DrawnPiece& p, std::mt19937_64&) { p.n_pieces = 0; },
    [](DrawnPiece& p, std::mt19937_64&) { p.n_pieces = 0xffffffff; },
    [](DrawnPiece& p, std::mt19937_64& r) { p.piece += 1 + static_cast<uint32_t>(r() % 3); },
    [](DrawnPiece& p, std::mt19937_64&) { p.piece = 0xffffffff; },
};

/// Pieces of two to four drawings, with some of them lost, doubled, exchanged or spoilt.
std::vector<DrawnPiece> disturbed(std::map<uint64_t, Sizes>& sizes, uint64_t& number,
                                  std::mt19937_64& random) {
  std::vector<DrawnPiece> all;
  for (uint64_t n = 2 + random() % 3; n > 0; --n) {
    // two to four pieces, all with lines
    const Sizes one{2049 + random() % 6000, 513 + random() % 100};
    sizes[++number] = {one.points, one.lines};
    auto pieces = cut(number, one);
    // in this file's cut the later pieces have no lines
    for (size_t i = 2; i < pieces.size(); ++i) pieces[i].lines = {};
    all.insert(all.end(), pieces.begin(), pieces.end());
  }
  for (uint64_t n = random() % 4; n > 0; --n) {
    const size_t at = random() % all.size();
    const auto place = all.begin() + static_cast<ptrdiff_t>(at);
    switch (random() % 4) {
      case 0:
        all.erase(place);
        break;
      case 1:
        all.insert(place, all[at]);
        break;
      case 2:
        std::swap(all[at], all[random() % all.size()]);
        break;
      default:
        if (all[at].lines.empty()) break;
        // so that it is seen wherever it is shown
        all[at].points[0].colour = 0xffffff;
        kSpoils[random() % std::size(kSpoils)](all[at], random);
    }
  }
  return all;
}

}  // namespace

TEST_CASE("drawing: lost, doubled, exchanged and spoilt pieces show a whole drawing or the last") {
  std::mt19937_64 random(20);
  DrawingPieces pieces;
  std::map<uint64_t, Sizes> sizes;
  uint64_t number = 0;
  int n_shown = 0;
  for (int run = 0; run < 400; ++run) {
    const uint64_t generation = 1 + static_cast<uint64_t>(run / 100);
    for (const auto& piece : disturbed(sizes, number, random)) {
      const uint64_t before = pieces.newest().number;
      const bool is_new = pieces.take(piece, generation);
      const Drawing& newest = pieces.newest();
      if (!is_new) {
        REQUIRE(newest.number == before);
        continue;
      }
      ++n_shown;
      REQUIRE(newest.number > before);
      REQUIRE(is_whole(newest, newest.number, sizes.at(newest.number)));
    }
  }
  // most runs leave some drawing as it was
  CHECK(n_shown > 400);
  // and all that was left undisturbed afterwards is shown
  for (const auto& piece : cut(++number, {4000, 600})) pieces.take(piece, 4);
  CHECK(is_whole(pieces.newest(), number, {4000, 600}));
}

TEST_CASE("drawing: whatever the bytes of pieces are, what is shown is bounded and finite") {
  std::mt19937_64 random(21);
  const auto piece = std::make_unique<DrawnPiece>();
  DrawingPieces pieces;
  uint64_t generation = 1, n_shown = 0;
  for (uint64_t run = 0; run < 3000; ++run) {
    *piece = cut(run + 1, {random() % 2049, random() % 513}).front();
    // one piece after the other of the longest drawings, then any bytes
    piece->drawing = 1 + run / 138;
    piece->piece = static_cast<uint32_t>(run % 138);
    piece->n_pieces = 138;
    if (random() % 8 == 0) {
      piece->piece = 0;
      piece->n_pieces = 1;
      piece->drawing = run;
    }
    auto* bytes = reinterpret_cast<std::byte*>(piece.get());
    for (uint64_t n = random() % 3; n > 0; --n) {
      bytes[random() % sizeof *piece] = static_cast<std::byte>(random());
    }
    generation += random() % 50 == 0;
    n_shown += pieces.take(*piece, generation);
    const Drawing& newest = pieces.newest();
    REQUIRE(newest.points.capacity() <= 200'000);
    REQUIRE(newest.lines.capacity() <= 20'000);
    for (const DrawnPoint& point : newest.points) {
      const bool is_good = std::isfinite(point.p_W.x + point.p_W.y + point.p_W.z) &&
                           point.radius > 0 && point.radius < 1e4;
      if (!is_good) FAIL("a point that cannot be shown");
    }
  }
  CHECK(n_shown > 50);
}

TEST_CASE("drawing: more points than may be are shown at no time, in however many pieces") {
  DrawingPieces pieces;
  const auto many = cut(1, {200'001, 0}), lines = cut(2, {0, 20'001}), just = cut(3, {200'000, 9});
  for (const auto& piece : many) CHECK_FALSE(pieces.take(piece, 1));
  for (const auto& piece : lines) CHECK_FALSE(pieces.take(piece, 1));
  CHECK(pieces.newest().generation == 0);
  for (const auto& piece : just) pieces.take(piece, 1);
  CHECK(is_whole(pieces.newest(), 3, {200'000, 9}));
  CHECK(pieces.newest().points.capacity() <= 200'000);
}

TEST_CASE("drawing: too much, or what nobody can see, is refused in a line that says which") {
  const auto refused = [](size_t n_points, size_t n_lines, const auto& spoil) -> std::string {
    auto points = points_of(1, n_points);
    auto lines = lines_of(1, n_lines);
    spoil(points, lines);
    try {
      check_drawing(points, lines);
      return "";
    } catch (const MessageError& error) {
      return error.what();
    }
  };
  const auto as_it_is = [](auto&, auto&) {};
  CHECK(refused(200'000, 20'000, as_it_is).empty());
  CHECK(refused(200'001, 0, as_it_is) ==
        "a drawing of 200001 points; at most 200000 are shown: leave some out");
  CHECK(refused(0, 20'001, as_it_is) ==
        "a drawing of 20001 lines; at most 20000 are shown: leave some out");
  CHECK(refused(9, 0, [](auto& points, auto&) { points[7].radius = 0; }) ==
        "point 7 of a drawing cannot be shown; its place is to be within 1 km, its radius above 0 "
        "m and at most 1 km");
  CHECK(refused(0, 9, [](auto&, auto& lines) { lines[3].to_W.x = kNone; }) ==
        "line 3 of a drawing cannot be shown; its ends are to be within 1 km");
}

TEST_CASE("drawing: a client that keeps the rate draws always, one that is faster does not") {
  const auto drawn = [](int64_t period_ns, int64_t jitter_ns, size_t points, size_t lines) {
    DrawingRate rate;
    std::mt19937_64 random(22);
    int n = 0;
    // ten seconds, from an instant of a machine that has been up for a day
    for (int64_t t_ns = 0; t_ns < 10'000 * kMs; t_ns += period_ns) {
      const auto late_ns = static_cast<int64_t>(random() % static_cast<uint64_t>(jitter_ns + 1));
      n += rate.take(86'400'000 * kMs + t_ns + late_ns, points, lines);
    }
    return n;
  };
  CHECK(drawn(kMs, 0, 20'000, 2'000) <= 601);
  CHECK(drawn(kMs, 0, 20'000, 2'000) >= 590);
  CHECK(drawn(kMs, 0, 20'001, 0) <= 51);
  CHECK(drawn(kMs, 0, 0, 2'001) <= 51);
  CHECK(drawn(20 * kMs, 8 * kMs, 100, 0) == 500);
  CHECK(drawn(200 * kMs, 20 * kMs, 200'000, 20'000) == 50);
  CHECK(drawn(500 * kMs, 0, 200'000, 0) == 20);
}

}  // namespace haptic
