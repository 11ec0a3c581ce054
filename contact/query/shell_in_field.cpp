// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/shell_in_field.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "contact/query/field_lanes.h"

namespace haptic {
namespace {

// half the diagonal of a cell: an interpolation of distances is off by no more; and a little for
// the rounding of what is stored
constexpr double kFieldError = 0.87;
// of the interpolation, on its way by the same rounding
constexpr double kSteepest = 1.74;
constexpr uint32_t kFewOf = 2;  // one in so many of a node's children are few
constexpr double kNotAsked = std::numeric_limits<double>::infinity();

/// How far the corner went that went furthest: |ΔR p + Δt| is convex in p, so no point between them
/// went further.
double travel_between(const Pose& before, const Pose& after, std::span<const Vec3> corners_T) {
  double travel = 0;
  for (const Vec3& p_T : corners_T) {
    travel = std::max(travel, norm(after * p_T - before * p_T));
  }
  return travel;
}

void note_travel(const Pose& X_OT, double reach, ShellCoherence& coherence) {
  if (coherence.is_fresh) {
    std::fill(coherence.free_until.begin(), coherence.free_until.end(), 0.0);
    coherence.travel = 0;
    coherence.is_fresh = false;
  } else {
    // a little more, for what is rounded away
    coherence.travel +=
        travel_between(coherence.X_OT, X_OT, coherence.corners_T) * (1 + 1e-12) + 1e-15;
    // a longer reach finds what is free now as a way nearer would
    coherence.travel += std::max(reach - coherence.reach, 0.0);
  }
  coherence.X_OT = X_OT;
  coherence.reach = reach;
}

/// How far a point goes at least before the field there says `reach`, and any point that is so far
/// from it. Negative: nothing is known.
double way_to(double reach, const FieldDistance& at, double cell) {
  const double less = at.distance - reach;
  // of what is far the true distance is known
  if (!at.is_near) return less - kFieldError * cell;
  return std::max(less / kSteepest, less - 2 * kFieldError * cell);
}

/// The search under way.
struct Search {
  const DistanceField& field;
  const Pointshell& shell;
  const Pose& X_OT;
  const ShellQuery& query;
  ShellCoherence* coherence;
  std::span<ShellVisit> visited;
  std::span<ShellTouch> touches;
  ShellAnswer answer;
  size_t n_visited = 0;
  FieldBatch batch;
  /// Nodes in order, and whether each is in the batch.
  struct Candidate {
    uint32_t node = 0;
    bool is_asked = false;
  };
  std::array<Candidate, FieldBatch::kRoom> candidates;
  size_t n_candidates = 0;
  std::array<uint32_t, FieldBatch::kRoom> points;  // of the finest level, in the batch

  bool is_free(uint32_t index) const {
    return coherence != nullptr && coherence->travel < coherence->free_until[index];
  }
  bool is_in_vain(uint32_t index) const {
    return coherence != nullptr && coherence->travel < -coherence->free_until[index];
  }

  uint32_t children_to_ask(const ShellNode& node) const {
    uint32_t n = 0;
    for (uint32_t k = 0; k < node.n_children; ++k) n += is_free(node.first_child + k) ? 0 : 1;
    return n;
  }

  /// Whether most of a node's children are free though it is not: then the others are asked in its
  /// place.
  bool has_few_to_ask(const ShellNode& node) const {
    return kFewOf * children_to_ask(node) <= node.n_children && node.n_children > 0;
  }

  /// Has a node looked up, together with those that come next, or kept as it is.
  void visit(uint32_t index) {
    const bool is_asked = !is_in_vain(index) && !has_few_to_ask(shell.nodes[index]);
    candidates[n_candidates++] = {index, is_asked};
    if (is_asked) put_in_batch(shell.nodes[index].point);
    if (n_candidates == candidates.size()) finish_batch();
  }

  void put_in_batch(uint32_t point) {
    batch.x[batch.n] = shell.x[point];
    batch.y[batch.n] = shell.y[point];
    batch.z[batch.n] = shell.z[point];
    ++batch.n;
  }

  void look_up_batch() {
    look_up(field, X_OT, batch);
    answer.tested += static_cast<uint32_t>(batch.n);
  }

  /// Until when what is so clear of the reach is free; negative: until when what is not clear is
  /// asked in vain.
  double until(double clear) const {
    return clear > 0 ? coherence->travel + clear : clear - coherence->travel;
  }

  /// Keeps of the candidates what may have anything within reach.
  void finish_batch() {
    look_up_batch();
    size_t asked = 0;
    for (const auto& [index, is_asked] : std::span(candidates.data(), n_candidates)) {
      if (!is_asked) {
        visited[n_visited++] = {index, kNotAsked};
        continue;
      }
      const FieldDistance& at = batch.found[asked++];
      const double clear =
          way_to(query.reach, at, field.cell) - static_cast<double>(shell.nodes[index].radius);
      // which are clear cannot be foretold: written in any case, counted where it is kept
      visited[n_visited] = {index, at.distance};
      n_visited += clear > 0 ? 0 : 1;
      if (coherence != nullptr) coherence->free_until[index] = until(clear);
    }
    batch.n = n_candidates = 0;
  }

  /// Nodes of the next level, below these.
  void ask_nodes(std::span<const ShellVisit> parents) {
    for (const ShellVisit& parent : parents) {
      const ShellNode& node = shell.nodes[parent.node];
      uint32_t free = 0;
      for (uint32_t k = node.first_child; k < node.first_child + node.n_children; ++k) {
        if (is_free(k)) {
          ++free;
        } else {
          visit(k);
        }
      }
      if (free == node.n_children) note_free(parent.node);
    }
    finish_batch();
  }

  /// Points of the finest level below these nodes: what is within reach is told. False where there
  /// is no more room.
  bool ask_points(std::span<const ShellVisit> parents) {
    for (const ShellVisit& parent : parents) {
      const ShellNode& node = shell.nodes[parent.node];
      uint32_t free = 0;
      for (uint32_t k = node.first_child; k < node.first_child + node.n_children; ++k) {
        // which are free cannot be foretold either
        points[batch.n] = shell.point_of(k);
        free += is_free(k) ? 1 : 0;
        batch.n += is_free(k) ? 0 : 1;
        if (batch.n == points.size() && !finish_points()) return false;
      }
      if (free == node.n_children) note_free(parent.node);
    }
    return finish_points();
  }

  /// A node whose children are all free is so as long as they are.
  void note_free(uint32_t index) {
    const ShellNode& node = shell.nodes[index];
    const auto first = coherence->free_until.begin() + node.first_child;
    coherence->free_until[index] = *std::min_element(first, first + node.n_children);
  }

  bool finish_points() {
    const size_t n = std::exchange(batch.n, 0);
    for (const uint32_t point : std::span(points.data(), n)) put_in_batch(point);
    look_up_batch();
    batch.n = 0;
    for (size_t k = 0; k < n; ++k) {
      const FieldDistance& at = batch.found[k];
      if (coherence != nullptr) {
        const double way = way_to(query.reach, at, field.cell);
        coherence->free_until[shell.leaf_of(points[k])] = way > 0 ? coherence->travel + way : 0;
      }
      if (!(at.distance < query.reach)) continue;
      if (answer.n == touches.size()) return false;
      touches[answer.n++] = {points[k], 1, at.distance};
    }
    return true;
  }

  /// Whether the next level, below these nodes, is within the budget.
  bool affords(size_t level, std::span<const ShellVisit> nodes) const {
    const uint32_t left = query.budget - std::min(query.budget, answer.tested);
    if (shell.levels[level + 1] - shell.levels[level] <= left) return true;
    uint32_t n = 0;
    for (const ShellVisit& visit : nodes) n += children_to_ask(shell.nodes[visit.node]);
    return n <= left;
  }

  /// Tells of coarser nodes, of which each stands for all below; those that were kept without are
  /// looked up first.
  bool tell_of(std::span<ShellVisit> kept) {
    for (ShellVisit& visit : kept) {
      const ShellNode& node = shell.nodes[visit.node];
      if (visit.distance == kNotAsked) {
        put_in_batch(node.point);
        look_up_batch();
        visit.distance = batch.found[0].distance;
        batch.n = 0;
      }
      if (!(visit.distance < query.reach)) continue;
      if (answer.n == touches.size()) return false;
      touches[answer.n++] = {node.point, node.count, visit.distance};
    }
    return true;
  }
};

}  // namespace

ShellCoherence::ShellCoherence(const Pointshell& shell) : free_until(shell.nodes.size(), 0) {
  if (shell.x.empty()) return;
  const auto [x0, x1] = std::minmax_element(shell.x.begin(), shell.x.end());
  const auto [y0, y1] = std::minmax_element(shell.y.begin(), shell.y.end());
  const auto [z0, z1] = std::minmax_element(shell.z.begin(), shell.z.end());
  for (size_t i = 0; i < corners_T.size(); ++i) {
    corners_T[i] = {static_cast<double>((i & 1) != 0 ? *x1 : *x0),
                    static_cast<double>((i & 2) != 0 ? *y1 : *y0),
                    static_cast<double>((i & 4) != 0 ? *z1 : *z0)};
  }
}

ShellAnswer find_touches(const DistanceField& field, const Pointshell& shell, const Pose& X_OT,
                         const ShellQuery& query, ShellCoherence* coherence,
                         std::span<ShellVisit> visited, std::span<ShellTouch> touches) {
  if (shell.nodes.empty() || field.index.empty() || visited.size() <= shell.nodes.size()) return {};
  // the way across it could not be told
  if (!is_finite(X_OT)) return {};
  if (coherence != nullptr) note_travel(X_OT, query.reach, *coherence);
  Search search{field, shell, X_OT, query, coherence, visited, touches, {}, 0, {}, {}, 0, {}};
  ShellAnswer& answer = search.answer;
  const size_t last = shell.levels.size() - 2;
  // level by level, the nodes that nothing keeps from being looked into
  size_t begin = 0;
  if (!search.is_free(0)) search.visit(0);
  search.finish_batch();
  for (; answer.level < last && begin < search.n_visited; ++answer.level) {
    const size_t end = search.n_visited;
    const std::span<ShellVisit> parents = visited.subspan(begin, end - begin);
    // a level is begun only where it can be ended
    if (!search.affords(answer.level + 1, parents)) {
      answer.is_complete = false;
      break;
    }
    begin = end;
    if (answer.level + 1 == last) {
      answer.is_complete = search.ask_points(parents);
      continue;
    }
    search.ask_nodes(parents);
  }
  if (!search.tell_of(visited.subspan(begin, search.n_visited - begin))) answer.is_complete = false;
  return answer;
}

}  // namespace haptic
