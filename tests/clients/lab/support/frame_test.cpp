// SPDX-License-Identifier: GPL-3.0-or-later
// `hapt demo frame` in lockstep: the part comes through the opening and ends on its pins.
#include <catch2/catch.hpp>

#include "clients/lockstep/lockstep.h"
#include "clients/report/rigid_pose.h"
#include "contact/bake/session.h"
#include "contact/query/proximity/triangle_pairs.h"
#include "proto/config/config.h"
#include "proto/wire/mapping.h"
#include "tests/support/data.h"
#include "tests/support/near.h"

namespace haptic {
namespace {

using namespace test;

constexpr uint32_t kOpening = 0, kRest = 1;

/// The session, and until when its hand is under way [s].
struct Frame {
  SessionConfig config = load_config(from_source("configs/frame.toml"));
  BakedSession baked = bake_session(config);
  ContactShapes shapes = baked.shapes();
  double end = 0;

  /// A hand that is that much quicker than the file says, for the time of a test.
  explicit Frame(double quicker) {
    IntentConfig& intent = config.device.hand.intent;
    for (uint32_t i = 0; i < intent.n_waypoints; ++i) {
      intent.waypoints[i].time /= quicker;
      end += intent.waypoints[i].time + intent.waypoints[i].rest;
    }
  }
};

const primitive::FrameRail& rail_of(const SessionConfig& config) {
  return std::get<primitive::FrameRail>(config.tool.primitive);
}

}  // namespace

TEST_CASE("frame: carried through the opening and laid on its pins, never inside of anything",
          "[lab]") {
  Frame frame(2.5);
  const auto device = open_device(frame.config.device);
  Lockstep lockstep(frame.config, frame.shapes, *device);
  std::vector<RigidPoseJudge> judges;
  for (const BakedShape& object : frame.baked.objects) {
    judges.emplace_back(object.shape, frame.baked.tool->shape);
  }
  size_t answers = 0, in_opening = 0;
  bool was_before = false, is_behind = false;
  const auto ticks = static_cast<int>(1000 * (frame.end + 0.5));
  for (int k = 0; k < ticks; ++k) {
    REQUIRE(lockstep.step());
    const ContactSet* set = lockstep.contacts();
    if (set == nullptr) continue;
    CAPTURE(k);
    REQUIRE((set->flags & kContactNoFreePose) == 0);
    // the exact test takes a millisecond: two in a hundred poses, and the last 20
    if (k % 50 == 0 || k + 20 > ticks) {
      ++answers;
      for (size_t i = 0; i < judges.size(); ++i) {
        REQUIRE_FALSE(judges[i].is_entered(inverse(set->objects[i].X_WO) * set->X_WG));
      }
    }
    const double x = set->X_WG.p.x - frame.config.objects[kOpening].X_WO.p.x;
    const double half = 0.5 * rail_of(frame.config).length;
    was_before |= x < -half;
    in_opening += std::abs(x) < half;
    is_behind = x > half;
  }
  CHECK(answers > 80);
  CHECK(was_before);
  CHECK(in_opening > 300);
  CHECK(is_behind);

  // where it lies: on the posts, and aside by the play of hole and slot at most, seen from the rest
  const primitive::FrameRail& part = rail_of(frame.config);
  const Pose X_OT = inverse(frame.config.objects[kRest].X_WO) * lockstep.contacts()->X_WG;
  const double play = part.clearance, apart = part.length - part.width;
  CAPTURE(X_OT.p, to_rotation_vector(X_OT.q));
  // the plane of the posts, with the margin that contact keeps
  CHECK(std::abs(X_OT.p.z) < 20e-6);
  // at the round hole, which is at −x
  const Vec3 hole = X_OT * Vec3{-0.5 * apart, 0, 0} - Vec3{-0.5 * apart, 0, 0};
  CHECK(std::hypot(hole.x, hole.y) <= play + 20e-6);
  const Vec3 slot = X_OT * Vec3{0.5 * apart, 0, 0} - Vec3{0.5 * apart, 0, 0};
  CHECK(std::abs(slot.y) <= play + 20e-6);
  const Vec3 turn = to_rotation_vector(X_OT.q);
  CHECK(std::hypot(turn.x, turn.y) < 1e-3);
  CHECK(std::abs(turn.z) <= 2 * (play + 20e-6) / apart);
  // and it is pressed down by the hand
  CHECK(lockstep.frame().F_device_B.f.y > 0.3);
}

TEST_CASE("frame: the part fits through the opening as it is tilted, and not when it is level",
          "[lab]") {
  const Frame frame(1);
  const IntentConfig& intent = frame.config.device.hand.intent;
  const MeshShape &opening = frame.baked.objects[kOpening].shape, &part = frame.baked.tool->shape;
  const Pose X_OW = inverse(frame.config.objects[kOpening].X_WO);
  // the upright tab is in the opening; it stands 0.3 to 0.6 of the channel's half behind the middle
  const primitive::FrameRail& rail = rail_of(frame.config);
  Vec3 way = intent.waypoints[1].X_BH.p;
  way.x = frame.config.objects[kOpening].X_WO.p.x + 0.45 * (0.5 * rail.length - rail.width);
  const auto meets = [&](const Vec3& aside, const Quat& q) {
    const Pose X_WT = tool_pose(frame.config.map, {}, {way + aside, q});
    return triangle_pairs(opening, part, X_OW * X_WT, {}) > 0;
  };
  CHECK_FALSE(meets({}, intent.waypoints[1].X_BH.q));
  // wherever a level one is in the opening
  constexpr double kStep = 1e-3;
  constexpr int kSteps = 20;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      CAPTURE(i, j);
      REQUIRE(meets({0, i * kStep, j * kStep}, {}));
    }
  }
}

}  // namespace haptic
