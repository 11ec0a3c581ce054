// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/clear_pose.h"

#include <algorithm>

#include "proto/math/motion_metric.h"

namespace haptic {
namespace {

// more than a hand of 2 m/s goes, and turns a tool of 0.1 m at 10 rad/s, in the 0.1 s for which old
// contacts are rendered [m]
constexpr double kFarthest = 0.5;
constexpr int kMostSteps = 8;           // a way from 0.1 mm off a wall to 25 mm, doubling
constexpr size_t kMostBoxes = 1 << 10;  // compared for one distance, of about 0.1 µs each

/// How far it is to what is nearest [m].
struct Room {
  double to_surface = kFarthest;  // at least
  double to_push = kFarthest;
};

Room room_at(const ClearanceModel& model, ClearanceState& state, std::span<const Pose> X_WO,
             const Pose& X_WT) {
  Room room;
  for (size_t i = 0; i < model.objects.size(); ++i) {
    const auto& [shape, layer] = model.objects[i];
    const TrianglePair* const witness = state[i] ? &*state[i] : nullptr;
    // what is further than another object does not matter
    const double enough = std::max(room.to_surface, room.to_push + layer);
    const MeshDistance distance =
        mesh_distance(shape, model.tool, inverse(X_WO[i]) * X_WT,
                      {enough / kLeastShare, witness, kLeastShare, kMostBoxes});
    if (distance.found) state[i] = distance.nearest.triangles;
    room.to_surface = std::min(room.to_surface, distance.at_least);
    room.to_push = std::min(room.to_push, distance.at_least - layer);
  }
  return room;
}

Pose centre_of(const ToolBody& body, const Pose& X_WT) {
  return {X_WT * body.centre_T, X_WT.q};
}

}  // namespace

ClearPose clear_pose(const ClearanceModel& model, ClearanceState& state, std::span<const Pose> X_WO,
                     const Pose& from, const Pose& to) {
  const ToolBody& body = model.body;
  Pose X_WT = from;
  Room room = room_at(model, state, X_WO, from);
  ClearPose clear{from, std::max(room.to_push, 0.0)};
  for (int step = 0; step < kMostSteps && room.to_surface > 0 && !(X_WT == to); ++step) {
    const Pose X_WC = centre_of(body, X_WT);
    const Twist way = way_between(X_WC, centre_of(body, to));
    const double length = norm(way.v) + body.radius * norm(way.w);
    X_WT = to;
    if (length > room.to_surface) {
      const Pose there = moved(X_WC, room.to_surface / length * way);
      X_WT = {there.p - rotate(there.q, body.centre_T), there.q};
    }
    const Room next = room_at(model, state, X_WO, X_WT);
    if (next.to_push > 0) clear = {X_WT, next.to_push};
    // a hand that presses leads nowhere
    if (!(next.to_push > 0 || next.to_surface > room.to_surface)) break;
    room = next;
  }
  return clear;
}

}  // namespace haptic
