// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/sweep/swept_mesh.h"

#include <algorithm>
#include <cmath>

#include "contact/shape/mesh/box.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kMostStretches = 256;      // of one motion, bounds the work
constexpr double kTimeRounding = 1e-12;  // of times, in half lengths of a sweep

/// Mean diagonal of the boxes of the leaves [m].
double leaf_size(const ObbTree& tree) {
  double sum = 0;
  size_t n = 0;
  for (const ObbNode& node : tree.nodes) {
    if (node.count == 0) continue;
    sum += 2 * norm(node.box.unpacked().half);
    ++n;
  }
  return n > 0 ? sum / static_cast<double>(n) : 0;
}

bool is_finite(const RigidMotion& motion) {
  return haptic::is_finite(Pose{motion.centre_O, motion.q_OT}) && haptic::is_finite(motion.way_O) &&
         haptic::is_finite(motion.turn_O) && haptic::is_finite(motion.centre_T);
}

}  // namespace

struct SweptMesh::Search {
  double tolerance;
  MotionStretch stretch;  // from the start of the search to the first meeting so far
  ObbSweep sweep;
  double sweep_from, sweep_to;
  MeshMeeting found;

  /// Time of the first meeting so far, in half lengths of the sweep from its middle: later windows
  /// are pruned.
  double latest() const {
    return 2 * (stretch.to - sweep_from) / (sweep_to - sweep_from) - 1 + kTimeRounding;
  }
};

SweptMesh::SweptMesh(const MeshShape& object, const MeshShape& tool)
    : object_(object),
      tool_(tool),
      object_owners_(object.mesh),
      tool_owners_(tool.mesh),
      reach_(std::max(largest_coordinate(object.mesh), largest_coordinate(tool.mesh))),
      leaf_size_(leaf_size(object.tree) + leaf_size(tool.tree)) {}

/// From the centre of rotation to the farthest corner of the tool's bounding box [m].
double SweptMesh::lever_of(const RigidMotion& motion) const {
  const Vec3 &lower = tool_.mesh.lower, &upper = tool_.mesh.upper, &centre = motion.centre_T;
  const Vec3 lever{std::max(upper.x - centre.x, centre.x - lower.x),
                   std::max(upper.y - centre.y, centre.y - lower.y),
                   std::max(upper.z - centre.z, centre.z - lower.z)};
  return norm(lever);
}

void SweptMesh::ask(Search& search, const SweptTriangle& swept_tool,
                    const TrianglePair& pair) const {
  const Corners face_O = corners_of(object_.mesh, pair.a);
  if (!may_meet(swept_tool, face_O)) return;
  const AskedFeatures asked{tool_owners_, object_owners_, pair.b, pair.a};
  const auto meeting = first_meeting(search.stretch, swept_tool, face_O, asked, search.tolerance);
  if (!meeting || (search.found.meets && meeting->time >= search.found.time)) return;
  search.found = {meeting->time, true, meeting->is_proven, pair};
  const MotionStretch& stretch = search.stretch;
  search.stretch = stretch_of(stretch.motion, stretch.from, meeting->time, reach_);
}

void SweptMesh::ask_leaves(Search& search, const ObbNode& a, const ObbNode& b) const {
  std::array<SweptTriangle, kLeafTriangles> swept_tool;
  for (uint32_t j = 0; j < b.count; ++j) {
    const uint32_t triangle = tool_.tree.order[b.first + j];
    swept_tool[j] = swept(corners_of(tool_.mesh, triangle), search.stretch);
  }
  for (uint32_t i = 0; i < a.count; ++i) {
    const uint32_t triangle = object_.tree.order[a.first + i];
    for (uint32_t j = 0; j < b.count; ++j) {
      ask(search, swept_tool[j], {triangle, tool_.tree.order[b.first + j]});
    }
  }
}

void SweptMesh::descend(Search& search) const {
  struct Entry {
    NodePair pair;
    double enter;
  };
  std::array<Entry, kMaxWaitingPairs> waiting;
  size_t n_waiting = 0;
  const auto look = [&](const NodePair& pair) {
    return when_boxes_may_meet(object_.tree.nodes[pair.a].box, tool_.tree.nodes[pair.b].box,
                               search.sweep);
  };
  const auto push = [&](const NodePair& pair, const SweepWindow& window) {
    HAPTIC_ASSERT(n_waiting < waiting.size());
    if (!window.is_empty()) waiting[n_waiting++] = {pair, window.enter};
  };
  push({}, look({}));
  while (n_waiting > 0) {
    const auto [pair, enter] = waiting[--n_waiting];
    if (enter > search.latest()) continue;
    const ObbNode &a = object_.tree.nodes[pair.a], &b = tool_.tree.nodes[pair.b];
    if (a.count > 0 && b.count > 0) {
      ask_leaves(search, a, b);
      continue;
    }
    const std::array<NodePair, 2> halves = opened(pair, object_.tree, tool_.tree);
    const std::array windows{look(halves[0]), look(halves[1])};
    // the earlier on top: its meeting may prune the other
    const size_t later = windows[0].enter > windows[1].enter ? 0 : 1;
    push(halves[later], windows[later]);
    push(halves[1 - later], windows[1 - later]);
  }
}

/// Number of stretches such that the bend of the motion in each is small in proportion to a leaf.
int SweptMesh::stretches_of(const RigidMotion& motion) const {
  const double bent = leaf_size_ > 0 ? std::sqrt(lever_of(motion) / leaf_size_) : 0;
  const double per_angle = std::max(5.0, bent);
  const double wanted = std::ceil(motion.angle * per_angle);
  return static_cast<int>(std::clamp(wanted, 1.0, 1.0 * kMostStretches));
}

MeshMeeting SweptMesh::time_of_impact(const RigidMotion& motion, double tolerance) {
  if (!is_finite(motion)) return {0, true, false, {}};
  if (object_.tree.nodes.empty() || tool_.tree.nodes.empty()) return {};
  HAPTIC_ASSERT(tolerance >= 0);
  Search search{tolerance, stretch_of(motion, 0, 1, reach_), {}, 0, 1, {}};
  if (witness_) {
    ask(search, swept(corners_of(tool_.mesh, witness_->b), search.stretch), *witness_);
  }
  const int n = stretches_of(motion);
  for (int i = 0; i < n; ++i) {
    const double from = static_cast<double>(i) / n;
    const double to = std::min(static_cast<double>(i + 1) / n, search.found.time);
    if (from >= to) break;
    HAPTIC_ASSERT(0 <= from && to <= 1);
    search.stretch = stretch_of(motion, from, to, reach_);
    search.sweep = sweep_between(motion, from, to);
    search.sweep_from = from, search.sweep_to = to;
    descend(search);
  }
  if (search.found.meets) witness_ = search.found.pair;
  return search.found;
}

MeshMeeting SweptMesh::time_of_impact(const RigidMotion& motion, double tolerance,
                                      std::span<const TrianglePair> pairs) {
  if (!is_finite(motion)) return {0, true, false, {}};
  Search search{tolerance, stretch_of(motion, 0, 1, reach_), {}, 0, 1, {}};
  for (const TrianglePair& pair : pairs) {
    ask(search, swept(corners_of(tool_.mesh, pair.b), search.stretch), pair);
  }
  if (search.found.meets) witness_ = search.found.pair;
  return search.found;
}

}  // namespace haptic
