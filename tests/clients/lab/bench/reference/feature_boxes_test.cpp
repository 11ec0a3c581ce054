// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/feature_boxes.h"

#include "tests/support/feature_queries.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr uint32_t kBoxes = 100'000;

}  // namespace

TEST_CASE("feature boxes: never later than a meeting that was made", "[trap]") {
  check_made_meetings(trials(10000), [](const std::array<SweptPoint, 4>& corners, bool is_face) {
    return meeting_by_boxes({corners, is_face, true}, 1e-8, kBoxes);
  });
}

TEST_CASE("feature boxes: rigid motions, never late against dense samples", "[trap]") {
  check_rigid_queries(trials(2500), [](const RigidQuery& query, const MotionStretch& stretch) {
    return meeting_by_boxes(query.path(stretch), 1e-7, kBoxes);
  });
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
  check_not_finite([](const SweptPoint& vertex, const std::array<SweptPoint, 3>& face) {
    return meeting_by_boxes({{vertex, face[0], face[1], face[2]}, true, false}, 1e-6, 500);
  });
}
