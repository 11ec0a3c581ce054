// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/volume/shell_in_field.h"

#include <algorithm>
#include <utility>

#include "contact/query/volume/field_lanes.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr uint32_t kFewOf = 2;  // children are few if at most one in so many needs testing
constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kNotAsked = kNever;
constexpr double kSlackRounding = 1e-12;  // rounding of the accumulated slack [m]
constexpr size_t kPatchLevels = 2;        // between patches and points; a patch fits into a batch

struct PointBatch {
  FieldBatch at;
  std::array<uint32_t, FieldBatch::kRoom> points;

  size_t room() const { return points.size() - at.n; }
  void add(uint32_t point) { points[at.n++] = point; }
};

struct Search {
  const DistanceField& field;
  const Pointshell& shell;
  const Pose& X_OT;
  const ShellQuery& query;
  ShellCoherence& coherence;
  std::span<ShellVisit> visited;
  std::span<ShellTouch> touches;
  uint32_t first_patch = 0;  // index of the first node that is a patch
  ShellAnswer answer = {};
  size_t n_visited = 0;
  PointBatch batch = {};
  /// Nodes in order, and whether their points are in the batch.
  struct Candidate {
    uint32_t node = 0;
    bool is_asked = false;
  };
  std::array<Candidate, FieldBatch::kRoom> candidates = {};
  size_t n_candidates = 0;
  /// The range of a patch in the batch: all its points that may be nearer than `cut`.
  struct Patch {
    uint32_t node = 0;
    size_t begin = 0, end = 0;
    double cut = 0;
  };
  std::array<Patch, FieldBatch::kRoom> patches = {};
  size_t n_patches = 0;
  uint32_t spare = 0;  // budget left for second look-ups

  bool is_free(uint32_t index) const { return coherence.wear < coherence.free_until[index]; }
  bool is_in_vain(uint32_t index) const {
    return index > 0 && coherence.wear < -coherence.free_until[index];
  }
  /// Travel at which this node must be tested again. Positive: it is farther than `reach` by
  /// `clear`. Negative: it is closer, and testing it before then cannot change that.
  double until(double clear) const {
    return clear > 0 ? coherence.wear + clear : clear - coherence.wear;
  }

  uint32_t children_to_ask(const ShellNode& node) const {
    uint32_t n = 0;
    for (uint32_t k = 0; k < node.n_children; ++k) n += is_free(node.first_child + k) ? 0 : 1;
    return n;
  }

  /// Whether most children of a node are free although the node is not: then its other children are
  /// tested instead of it. Not for patches: below them are points.
  bool has_few_to_ask(uint32_t index) const {
    const ShellNode& node = shell.nodes[index];
    return index < first_patch && kFewOf * children_to_ask(node) <= node.n_children;
  }

  void look_up_batch(PointBatch& points) {
    FieldBatch& at = points.at;
    for (size_t k = 0; k < at.n; ++k) {
      const uint32_t i = points.points[k];
      at.x[k] = shell.x[i], at.y[k] = shell.y[i], at.z[k] = shell.z[i];
    }
    look_up(field, X_OT, at);
    answer.tested += static_cast<uint32_t>(at.n);
  }

  /// Queues a node: for look-up, or as known to be near.
  void visit(uint32_t index) {
    const ShellNode& node = shell.nodes[index];
    const bool is_asked = !is_in_vain(index) && !has_few_to_ask(index);
    HAPTIC_ASSERT(n_candidates < candidates.size());
    candidates[n_candidates++] = {index, is_asked};
    if (is_asked) batch.add(node.point);
    if (n_candidates == candidates.size()) finish_nodes();
  }

  /// Looks the queue up, and keeps the nodes that may have points within reach.
  void finish_nodes() {
    look_up_batch(batch);
    size_t asked = 0;
    for (const auto& [index, is_asked] : std::span(candidates.data(), n_candidates)) {
      if (!is_asked) {
        visited[n_visited++] = {index, kNotAsked};
        continue;
      }
      const FieldDistance at = batch.at.found(asked++);
      const double clear =
          way_to(query.reach, at, field.cell) - static_cast<double>(shell.nodes[index].radius);
      // branch-free, since the outcome is unpredictable: always written, counted if kept
      visited[n_visited] = {index, at.distance};
      n_visited += clear > 0 ? 0 : 1;
      coherence.free_until[index] = until(clear);
    }
    batch.at.n = n_candidates = 0;
  }

  /// Queues the children of these nodes; stops where the budget less `reserved` ends, if anything
  /// is reserved.
  void ask_nodes(std::span<const ShellVisit> parents, size_t reserved) {
    for (const ShellVisit& parent : parents) {
      const ShellNode& node = shell.nodes[parent.node];
      if (reserved > 0 && batch.at.n + node.n_children + reserved > budget_left()) break;
      double free_until = kNever;
      for (uint32_t k = node.first_child; k < node.first_child + node.n_children; ++k) {
        free_until = std::min(free_until, coherence.free_until[k]);
        if (!is_free(k)) visit(k);
      }
      // a node is free as long as all its children are
      if (coherence.wear < free_until) coherence.free_until[parent.node] = free_until;
    }
    finish_nodes();
  }

  /// Adds the points of a node that may be nearer than `cut`.
  void gather_points(const ShellNode& node, double cut, PointBatch& to) const {
    const double* low = coherence.low.data();
    const double least = cut + coherence.slack + kSlackRounding;
    size_t n = to.at.n;
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      // branch-free, as in finish_nodes
      to.points[n] = i;
      n += low[i] < least ? 1 : 0;
    }
    to.at.n = n;
  }

  /// Distance below which points of a patch are reported [m]: the points that touch, and the
  /// nearest of the others.
  double cut_of(uint32_t index) const {
    return std::min(query.reach, std::max(query.touch, coherence.high[index] + coherence.slack));
  }

  /// Looks up the points of these nodes, and reports those within reach. False if there is no room
  /// left, or if the budget less `reserved` ends.
  bool ask_points(std::span<const ShellVisit> nodes, size_t reserved) {
    for (const ShellVisit& visit : nodes) {
      const ShellNode& node = shell.nodes[visit.node];
      if (batch.room() < node.count && !finish_patches()) return false;
      const size_t begin = batch.at.n;
      const double cut = cut_of(visit.node);
      gather_points(node, cut, batch);
      if (batch.at.n + reserved > budget_left()) {
        batch.at.n = begin;
        finish_patches();
        return false;
      }
      if (batch.at.n > begin) {
        HAPTIC_ASSERT(n_patches < patches.size());
        patches[n_patches++] = {visit.node, begin, batch.at.n, cut};
      } else {
        note_free(visit.node);
      }
    }
    return finish_patches();
  }

  /// Spends what these nodes leave of the budget on bounds for their children, so that fewer need
  /// testing in the next queries.
  void learn(std::span<const ShellVisit> nodes, bool are_patches) {
    const size_t kept = n_visited;
    if (are_patches) {
      ask_points(nodes, nodes.size());
    } else {
      ask_nodes(nodes, nodes.size());
    }
    n_visited = kept;
    answer.n = 0;
  }

  /// A node is free as long as none of its points may be within reach.
  void note_free(uint32_t index) {
    const ShellNode& node = shell.nodes[index];
    const auto first = coherence.low.begin() + node.first;
    const double low = *std::min_element(first, first + node.count);
    coherence.free_until[index] = coherence.wear + travel_until(low, query.reach, coherence);
  }

  bool finish_patches() {
    look_up_points(batch);
    bool has_room = true;
    for (size_t i = 0; i < n_patches && has_room; ++i) has_room = tell_of(patches[i], batch);
    batch.at.n = n_patches = 0;
    return has_room;
  }

  void look_up_points(PointBatch& points) {
    look_up_batch(points);
    for (size_t k = 0; k < points.at.n; ++k) {
      coherence.low[points.points[k]] = low_end(field, points.at.found(k)) + coherence.slack;
    }
  }

  /// Reports the points of a patch that touch, and the nearest of the others.
  bool tell_of(const Patch& patch, const PointBatch& points) {
    const ShellNode& node = shell.nodes[patch.node];
    ShellTouch nearest{0, node.count, query.reach};
    bool touching = false;
    for (size_t k = patch.begin; k < patch.end; ++k) {
      const double distance = points.at.distance[k];
      touching |= distance < query.touch;
      const bool is_nearer = distance >= query.touch && distance < nearest.distance;
      nearest.point = is_nearer ? points.points[k] : nearest.point;
      nearest.distance = is_nearer ? distance : nearest.distance;
    }
    if (nearest.distance > patch.cut) {
      if (node.count <= spare) return look_again(patch.node);
      answer.is_complete = false;
    }
    const bool is_near = nearest.distance < query.reach;
    coherence.high[patch.node] = is_near ? nearest.distance - coherence.slack : kNever;
    for (size_t k = patch.begin; touching && k < patch.end; ++k) {
      const double distance = points.at.distance[k];
      if (!(distance < std::min(query.touch, query.reach))) continue;
      if (answer.n == touches.size()) return false;
      touches[answer.n++] = {points.points[k], 1, distance};
    }
    if (!is_near) return true;
    if (answer.n == touches.size()) return false;
    touches[answer.n++] = nearest;
    return true;
  }

  /// The bound of the nearest point failed, since that point has moved away or touches: looks up
  /// all candidates of the patch.
  bool look_again(uint32_t index) {
    spare -= shell.nodes[index].count;
    PointBatch again;
    gather_points(shell.nodes[index], query.reach, again);
    look_up_points(again);
    return tell_of({index, 0, again.at.n, query.reach}, again);
  }

  uint32_t budget_left() const { return query.budget - std::min(query.budget, answer.tested); }

  /// Number of points of these nodes that need a look-up; stops counting at the budget.
  uint32_t points_to_ask(std::span<const ShellVisit> nodes) const {
    uint32_t n = 0;
    PointBatch may_be_near;
    for (size_t i = 0; i < nodes.size() && n <= budget_left(); ++i) {
      gather_points(shell.nodes[nodes[i].node], cut_of(nodes[i].node), may_be_near);
      n += static_cast<uint32_t>(std::exchange(may_be_near.at.n, 0));
    }
    return n;
  }

  /// Whether all points of these nodes are within the budget; sets `spare`.
  bool affords_points(std::span<const ShellVisit> nodes) {
    size_t all = 0;
    for (const ShellVisit& visit : nodes) all += shell.nodes[visit.node].count;
    // the exact number only if it may decide
    const uint32_t to_ask =
        all <= budget_left() / 2 ? static_cast<uint32_t>(all) : points_to_ask(nodes);
    if (to_ask > budget_left()) return false;
    spare = budget_left() - to_ask;
    return true;
  }

  /// Whether the next level, below these nodes, is within the budget.
  bool affords_nodes(std::span<const ShellVisit> nodes) const {
    uint32_t n = answer.tested;
    const size_t next = answer.level + 1;
    if (shell.levels[next + 1] - shell.levels[next] <= budget_left()) return true;
    for (const ShellVisit& visit : nodes) n += children_to_ask(shell.nodes[visit.node]);
    return n <= query.budget;
  }

  /// Reports nodes as representatives of their subtrees; those that were not looked up are now, as
  /// far as the budget allows.
  bool tell_of_nodes(std::span<ShellVisit> kept) {
    const auto is_unknown = [&](const ShellVisit& visit) { return visit.distance == kNotAsked; };
    for (auto visit = kept.begin(); visit != kept.end();) {
      const auto first = visit;
      for (; visit != kept.end() && batch.room() > 0 && batch.at.n < budget_left(); ++visit) {
        if (is_unknown(*visit)) batch.add(shell.nodes[visit->node].point);
      }
      if (visit == first) break;
      look_up_batch(batch);
      size_t asked = 0;
      for (auto it = first; it != visit; ++it) {
        if (is_unknown(*it)) it->distance = batch.at.distance[asked++];
      }
      batch.at.n = 0;
    }
    for (const ShellVisit& visit : kept) {
      const ShellNode& node = shell.nodes[visit.node];
      if (!(visit.distance < query.reach)) continue;
      if (answer.n == touches.size()) return false;
      touches[answer.n++] = {node.point, node.count, visit.distance};
    }
    return true;
  }
};

}  // namespace

ShellAnswer find_touches(const DistanceField& field, const Pointshell& shell, const Pose& X_OT,
                         const ShellQuery& query, ShellCoherence& coherence,
                         std::span<ShellVisit> visited, std::span<ShellTouch> touches) {
  if (shell.nodes.empty() || field.index.empty()) return {};
  // travel to a pose that is not finite is undefined
  if (!is_finite(X_OT) || visited.size() <= shell.nodes.size()) return {.is_complete = false};
  HAPTIC_ASSERT(coherence.free_until.size() == shell.nodes.size());
  note_travel(X_OT, query.reach, coherence);
  HAPTIC_ASSERT(shell.levels.size() >= 2);
  const size_t last = shell.levels.size() - 2;  // level of the points
  Search search{.field = field,
                .shell = shell,
                .X_OT = X_OT,
                .query = query,
                .coherence = coherence,
                .visited = visited,
                .touches = touches,
                .first_patch = shell.levels[last - std::min(last, kPatchLevels)]};
  ShellAnswer& answer = search.answer;
  if (!search.is_free(0)) search.visit(0);
  search.finish_nodes();
  // level by level, over the nodes that could not be excluded
  for (size_t begin = 0; begin < search.n_visited; ++answer.level) {
    const size_t end = search.n_visited;
    const std::span<ShellVisit> nodes = visited.subspan(begin, end - begin);
    const bool are_patches = answer.level + kPatchLevels >= last;
    if (are_patches && search.affords_points(nodes)) {
      if (!search.ask_points(nodes, 0)) answer.is_complete = false;
      answer.level = last;
      break;
    }
    // a level is begun only if it can be completed
    if (are_patches || !search.affords_nodes(nodes)) {
      search.learn(nodes, are_patches);
      search.tell_of_nodes(nodes);
      answer.is_complete = false;
      break;
    }
    search.ask_nodes(nodes, 0);
    begin = end;
  }
  return answer;
}

}  // namespace haptic
