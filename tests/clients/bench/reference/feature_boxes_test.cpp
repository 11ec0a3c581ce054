// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/bench/reference/feature_boxes.h"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/feature_queries.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr uint32_t kBoxes = 100'000;

}  // namespace

TEST_CASE("feature boxes: never later than a meeting that was made", "[trap]") {
  Random random(4);
  double latest = -1, earliest = 0;
  for (size_t k = 0; k < trials(10000); ++k) {
    const bool is_face = k % 2 == 0;
    const MadeMeeting made = made_meeting(random, is_face);
    const auto hit = meeting_by_boxes({made.corners, is_face, true}, 1e-8, kBoxes);
    REQUIRE(hit);
    latest = std::max(latest, hit->time - made.time);
    // there may have been an earlier contact, of two edges or a face that turns
    earliest += hit->time < made.time - 1e-3 ? 1 : 0;
  }
  CHECK(latest <= 1e-12);
  CHECK(earliest < 0.02 * static_cast<double>(trials(10000)));
}

TEST_CASE("feature boxes: rigid motions, never late against dense samples", "[trap]") {
  Random random(5);
  size_t meetings = 0, unproven = 0;
  for (size_t k = 0; k < trials(2500); ++k) {
    const RigidQuery query = random_rigid_query(random, static_cast<RigidQuery::Kind>(k % 3));
    const MotionStretch stretch = stretch_of(query.motion, 0, 1, 4e-3);
    const auto hit = meeting_by_boxes(query.path(stretch), 1e-7, kBoxes);
    meetings += hit ? 1 : 0;
    unproven += hit && !hit->is_proven ? 1 : 0;
    REQUIRE_FALSE(pass_before(query, hit ? hit->time : 1));
  }
  CAPTURE(meetings, unproven);
  CHECK(meetings > trials(2500) / 50);
  CHECK(unproven == 0);
}

TEST_CASE("feature boxes: a near miss is told from a meeting, which contact does not do") {
  // an edge that passes above a slanted one by half the tolerance; no axis keeps them apart
  const Vec3 low{-1, 0, -0.5}, high{1, 0, 0.5};
  const std::array<SweptPoint, 2> still{{{low, low}, {high, high}}};
  const auto passing = [](double miss) {
    const double above = 0.05 + miss;
    return std::array<SweptPoint, 2>{
        {{{0.1, -2, above}, {0.1, 1, above}}, {{0.1, -1, above}, {0.1, 2, above}}}};
  };
  const auto query = [&](double above) {
    const auto edge = passing(above);
    return CcdQuery{{still[0], still[1], edge[0], edge[1]}, false, above == 0};
  };
  CHECK(meeting_of(query(5e-4), 1e-3));
  CHECK_FALSE(meeting_by_boxes(query(5e-4), 1e-4, kBoxes));
  CHECK(meeting_by_boxes(query(0), 1e-4, kBoxes));
}

TEST_CASE("feature boxes: corners that are not finite meet at once, unproven") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const SweptPoint a{{-1, -1, 0}, {-1, -1, 0}}, b{{2, -1, 0}, {2, -1, 0}},
      c{{-1, 2, 0}, {-1, 2, 0}};
  for (const double bad : {nan, infinity, -infinity}) {
    for (const SweptPoint& vertex :
         {SweptPoint{{0, 0, 1}, {0, 0, bad}}, SweptPoint{{bad, 0, 1}, {0, 0, -1}}}) {
      const auto hit = meeting_by_boxes({{vertex, a, b, c}, true, false}, 1e-6, 500);
      REQUIRE(hit);
      CHECK(hit->time == 0);
      CHECK_FALSE(hit->is_proven);
    }
  }
}
