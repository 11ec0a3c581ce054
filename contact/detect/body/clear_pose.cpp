// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/clear_pose.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"

namespace haptic {
namespace {

// [m]; exceeds the motion of a hand at 2 m/s with a tool of 0.1 m rotating at 10 rad/s in the 0.1 s
// for which old contacts are rendered
constexpr double kFarthest = 0.5;
constexpr int kMostSteps = 8;           // doubling, from 0.1 mm to 25 mm
constexpr size_t kMostBoxes = 1 << 12;  // box tests in all, about 0.05 µs each

/// Lower bounds of the distances to the nearest surface and to the layer of each object [m].
struct Room {
  double to_surface = kFarthest;
  double to_push = kFarthest;  // of the nearest object
  PerObject<double> clearance;
};

/// Remaining budget, and whether only large distances are of use.
struct Effort {
  size_t boxes = kMostBoxes;
  bool is_far_alone = false;
};

Room room_at(const ClearanceModel& model, ClearanceState& state, std::span<const Pose> X_WO,
             const Pose& X_WT, Effort& effort) {
  Room room;
  for (size_t i = 0; i < model.objects.size(); ++i) {
    const auto& [shape, layer] = model.objects[i];
    DistanceSearch search;
    search.limit = (kFarthest + layer) / kLeastShare;
    search.witness = state[i] ? &*state[i] : nullptr;
    search.share = kLeastShare;
    search.least = effort.is_far_alone ? layer + model.least : 0;
    search.most_boxes = effort.boxes;
    const MeshDistance found = mesh_distance(shape, model.tool, inverse(X_WO[i]) * X_WT, search);
    effort.boxes -= std::min(effort.boxes, found.n_boxes);
    if (found.found) state[i] = found.nearest.triangles;
    room.to_surface = std::min(room.to_surface, found.at_least);
    room.clearance.push_back(std::max(found.at_least - layer, 0.0));
    room.to_push = std::min(room.to_push, room.clearance.back());
  }
  return room;
}

Pose centre_of(const ToolBody& body, const Pose& X_WT) {
  return {X_WT * body.centre_T, X_WT.q};
}

}  // namespace

ClearPose clear_pose(const ClearanceModel& model, ClearanceState& state, std::span<const Pose> X_WO,
                     const Pose& from, const Pose& to) {
  HAPTIC_ASSERT(model.objects.size() <= X_WO.size() && model.objects.size() == state.size());
  HAPTIC_ASSERT(model.objects.size() <= kMaxObjects);
  HAPTIC_ASSERT(is_finite(from) && is_finite(to));
  const ToolBody& body = model.body;
  Pose X_WT = from;
  // a tool that is at its target needs no path
  Effort effort{kMostBoxes, from == to};
  Room room = room_at(model, state, X_WO, from, effort);
  ClearPose clear{from, room.clearance};
  for (int step = 0; step < kMostSteps && room.to_surface > 0 && !(X_WT == to); ++step) {
    const Pose X_WC = centre_of(body, X_WT);
    const Twist way = way_between(X_WC, centre_of(body, to));
    const double length = largest_travel(way, body.radius);
    X_WT = to;
    if (length > room.to_surface) {
      const Pose there = moved(X_WC, room.to_surface / length * way);
      X_WT = {there.p - rotate(there.q, body.centre_T), there.q};
    }
    const Room next = room_at(model, state, X_WO, X_WT, effort);
    if (next.to_push > 0) clear = {X_WT, next.clearance};
    // a hand that presses on makes no progress
    if (!(next.to_push > 0 || next.to_surface > room.to_surface)) break;
    room = next;
  }
  return clear;
}

}  // namespace haptic
