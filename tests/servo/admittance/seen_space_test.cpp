// SPDX-License-Identifier: GPL-3.0-or-later
// How far a tool may go where contact has looked. The reach is written out in numbers.
#include "servo/admittance/seen_space.h"

#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

ContactSet answer_to(uint64_t tick, uint32_t flags = 0) {
  ContactSet set{};
  set.answers_tick = tick;
  set.flags = flags;
  return set;
}

}  // namespace

TEST_CASE("seen space: nothing is known of a tick that was not noted", "[servo]") {
  SeenSpace seen;
  CHECK(seen_radius(seen, answer_to(0), {}, false, kTick) == 0);
  note_asked(seen, 7, 1);
  CHECK(seen_radius(seen, answer_to(7), {}, false, kTick) > 0);
  CHECK(seen_radius(seen, answer_to(8), {}, false, kTick) == 0);
  // 256 ticks later another one is in its place
  CHECK(seen_radius(seen, answer_to(7 + SeenSpace::kTicks), {}, false, kTick) == 0);
  note_asked(seen, 7 + SeenSpace::kTicks, 1);
  CHECK(seen_radius(seen, answer_to(7), {}, false, kTick) == 0);
}

TEST_CASE("seen space: twice three ticks of way, less the two that contact is ahead", "[servo]") {
  SeenSpace seen;
  // 1 m/s at 1 kHz: 2 · 3 mm − 2 mm
  note_asked(seen, 1, 1);
  CHECK(seen_radius(seen, answer_to(1), {}, false, kTick) == Approx(4e-3));
  // at rest twice the least reach of 0.2 mm, of a body too
  note_asked(seen, 2, 0);
  CHECK(seen_radius(seen, answer_to(2), {}, false, kTick) == Approx(0.4e-3));
  CHECK(seen_radius(seen, answer_to(2), {}, true, kTick) == Approx(0.4e-3));
  // contact every 5 ms: 2 · 11 mm, which is bounded at 20 mm, less 2 mm
  Age slow;
  slow.median_ns = 5'000'000;
  CHECK(seen_radius(seen, answer_to(1), slow, false, kTick) == Approx(18e-3));
  note_asked(seen, 3, 0.5);
  CHECK(seen_radius(seen, answer_to(3), slow, false, kTick) == Approx(10e-3));
  // faster than contact can look ahead
  note_asked(seen, 4, 100);
  CHECK(seen_radius(seen, answer_to(4), {}, false, kTick) == 0);
}

TEST_CASE("seen space: a set without a free pose says nothing, a cut one little", "[servo]") {
  SeenSpace seen;
  note_asked(seen, 1, 1);
  CHECK(seen_radius(seen, answer_to(1, kContactNoFreePose), {}, false, kTick) == 0);
  CHECK(seen_radius(seen, answer_to(1, kContactTruncated), {}, false, kTick) == Approx(25e-6));
}

TEST_CASE("seen space: a tool goes half of what is left to the rim, and never beyond", "[servo]") {
  const Pose centre, from{{1e-3, 0, 0}, {}};
  const Pose near{{1.4e-3, 0, 0}, {}}, far{{9e-3, 0, 0}, {}};
  CHECK(kept_within(centre, 2e-3, 0, from, near) == near);
  CHECK_THAT(kept_within(centre, 2e-3, 0, from, far).p, IsNear({1.5e-3, 0, 0}, 1e-12));
  CHECK(kept_within(centre, 0.5e-3, 0, from, far).p == from.p);
  Pose at = from;
  for (int k = 0; k < 100; ++k) at = kept_within(centre, 2e-3, 0, at, far);
  CHECK(at.p.x <= 2e-3);
  CHECK(at.p.x > 1.999e-3);
}

TEST_CASE("seen space: a tool that turns counts with its rim", "[servo]") {
  const Pose from, turned{{}, from_rotation_vector({0, 0, 0.2})};
  // 50 mm away from the origin 0.2 rad are 10 mm; half of 4 mm is 0.04 rad
  const Pose kept = kept_within({}, 4e-3, 0.05, from, turned);
  CHECK_THAT(to_rotation_vector(kept.q), IsNear({0, 0, 0.04}, 1e-9));
  CHECK(kept_within({}, 4e-3, 0, from, turned) == turned);
}
