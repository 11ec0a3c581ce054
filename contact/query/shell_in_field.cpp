// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/shell_in_field.h"

#include <algorithm>
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
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNotAsked = kInfinite;
constexpr double kRounding = 1e-12;  // of sums of all that was ever travelled [m]
constexpr size_t kRanks = 32;        // of what is near, where the budget is short
constexpr size_t kPatchLevels = 2;   // above the points; a node there holds at most a batch of them

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
    std::fill(coherence.low.begin(), coherence.low.end(), -kInfinite);
    std::fill(coherence.high.begin(), coherence.high.end(), kInfinite);
    coherence.slack = coherence.wear = 0;
    coherence.is_fresh = false;
  } else {
    // a little more, for what is rounded away
    const double travel =
        travel_between(coherence.X_OT, X_OT, coherence.corners_T) * (1 + 1e-12) + 1e-15;
    coherence.slack += kSteepest * travel;
    // a longer reach finds what is free now as a way nearer would
    coherence.wear += travel + std::max(reach - coherence.reach, 0.0);
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

/// What the field says there at least, after it has changed by a slack: no less than the result
/// less the slack, as far as anything within the band is concerned.
double low_end(const DistanceField& field, const FieldDistance& at) {
  if (at.is_near) return at.distance;
  // of what is far the true distance is known, which changes by no more than the travel
  const double low = at.distance - kFieldError * field.cell, beyond = low - field.band;
  return beyond > 0 ? field.band + kSteepest * beyond : low;
}

/// Points of the shell that are looked up together.
struct PointBatch {
  FieldBatch at;
  std::array<uint32_t, FieldBatch::kRoom> points;

  size_t room() const { return points.size() - at.n; }
  void add(uint32_t point) { points[at.n++] = point; }
};

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
  PointBatch batch;
  /// Nodes in order, and whether each is in the batch.
  struct Candidate {
    uint32_t node = 0;
    bool is_asked = false;
  };
  std::array<Candidate, FieldBatch::kRoom> candidates;
  size_t n_candidates = 0;
  /// Where the points of a patch are in the batch: all that may be nearer than `cut`.
  struct Patch {
    uint32_t node = 0;
    size_t begin = 0, end = 0;
    double cut = 0;
  };
  std::array<Patch, FieldBatch::kRoom> patches;
  size_t n_patches = 0;
  uint32_t reserved = 0;  // of the budget

  bool is_free(uint32_t index) const {
    return coherence != nullptr && coherence->wear < coherence->free_until[index];
  }
  bool is_in_vain(uint32_t index) const {
    return coherence != nullptr && coherence->wear < -coherence->free_until[index];
  }
  /// Until when what is so clear of the reach is free; negative: until when what is not clear is
  /// asked in vain.
  double until(double clear) const {
    return clear > 0 ? coherence->wear + clear : clear - coherence->wear;
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

  void look_up_batch(PointBatch& points) {
    FieldBatch& at = points.at;
    for (size_t k = 0; k < at.n; ++k) {
      const uint32_t i = points.points[k];
      at.x[k] = shell.x[i], at.y[k] = shell.y[i], at.z[k] = shell.z[i];
    }
    look_up(field, X_OT, at);
    answer.tested += static_cast<uint32_t>(at.n);
  }

  /// Has a node looked up, together with those that come next, or kept as it is.
  void visit(uint32_t index) {
    const ShellNode& node = shell.nodes[index];
    const bool is_asked = !is_in_vain(index) && !has_few_to_ask(node);
    candidates[n_candidates++] = {index, is_asked};
    if (is_asked) batch.add(node.point);
    if (n_candidates == candidates.size()) finish_nodes();
  }

  /// Keeps of the candidates what may have anything within reach.
  void finish_nodes() {
    look_up_batch(batch);
    size_t asked = 0;
    for (const auto& [index, is_asked] : std::span(candidates.data(), n_candidates)) {
      if (!is_asked) {
        visited[n_visited++] = {index, 0, kNotAsked};
        continue;
      }
      const FieldDistance at = batch.at.found(asked++);
      const double clear =
          way_to(query.reach, at, field.cell) - static_cast<double>(shell.nodes[index].radius);
      // which are clear cannot be foretold: written in any case, counted where it is kept
      visited[n_visited] = {index, 0, at.distance};
      n_visited += clear > 0 ? 0 : 1;
      if (coherence != nullptr) coherence->free_until[index] = until(clear);
    }
    batch.at.n = n_candidates = 0;
  }

  /// Nodes of the next level, below these.
  void ask_nodes(std::span<const ShellVisit> parents) {
    for (const ShellVisit& parent : parents) {
      const ShellNode& node = shell.nodes[parent.node];
      double free_until = kInfinite;
      for (uint32_t k = node.first_child; k < node.first_child + node.n_children; ++k) {
        if (coherence != nullptr) free_until = std::min(free_until, coherence->free_until[k]);
        if (!is_free(k)) visit(k);
      }
      // a node whose children are all free is so as long as they are
      if (coherence != nullptr && coherence->wear < free_until) {
        coherence->free_until[parent.node] = free_until;
      }
    }
    finish_nodes();
  }

  /// Adds the points of a node that may be nearer than `cut`.
  void gather_points(const ShellNode& node, double cut, PointBatch& to) const {
    if (coherence == nullptr) {
      for (uint32_t i = node.first; i < node.first + node.count; ++i) to.add(i);
      return;
    }
    const double* low = coherence->low.data();
    const double least = cut + coherence->slack + kRounding;
    size_t n = to.at.n;
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      // which are near cannot be foretold either
      to.points[n] = i;
      n += low[i] < least ? 1 : 0;
    }
    to.at.n = n;
  }

  /// Nearer than this are the points of a patch that touch, and the nearest of the others.
  double cut_of(uint32_t index) const {
    if (coherence == nullptr) return query.reach;
    return std::min(query.reach, std::max(query.touch, coherence->high[index] + coherence->slack));
  }

  /// Asks the points below a node, together with those that come next. False where there is no
  /// more room for what is told.
  bool ask_points(uint32_t index) {
    const ShellNode& node = shell.nodes[index];
    if (batch.room() < node.count && !finish_patches()) return false;
    const double cut = cut_of(index);
    const size_t begin = batch.at.n;
    gather_points(node, cut, batch);
    if (batch.at.n > begin) {
      patches[n_patches++] = {index, begin, batch.at.n, cut};
    } else {
      note_free(index);
    }
    return true;
  }

  bool ask_all_points(std::span<const ShellVisit> nodes) {
    for (const ShellVisit& visit : nodes) {
      if (!ask_points(visit.node)) return false;
    }
    return finish_patches();
  }

  /// With a budget that is short: first what may touch, then what may be nearest. A node whose
  /// points may touch and go without stands for them. Needs a budget of the nodes' number.
  bool ask_nearest_points(std::span<ShellVisit> nodes) {
    std::array<uint32_t, kRanks> to_ask{};
    uint32_t stand_ins = 0;
    for (ShellVisit& visit : nodes) {
      survey(visit);
      const size_t rank = rank_of(visit.distance);
      to_ask[rank] += visit.to_ask;
      stand_ins += rank == 0 ? 1 : 0;
    }
    reserved = to_ask[0] <= budget_left() ? 0 : stand_ins;
    size_t last = 0;
    for (uint32_t n = to_ask[0]; n <= budget_left() && last + 1 < kRanks; n += to_ask[last]) ++last;
    size_t n_stand_ins = 0;
    for (const ShellVisit& visit : nodes) {
      const size_t rank = rank_of(visit.distance);
      if (rank > last) continue;
      const uint32_t asked = answer.tested + static_cast<uint32_t>(batch.at.n);
      if (asked + visit.to_ask + reserved <= query.budget) {
        if (!ask_points(visit.node)) return false;
      } else if (rank == 0) {
        nodes[n_stand_ins++] = {visit.node, 0, kNotAsked};
      }
    }
    return finish_patches() && tell_of_nodes(nodes.first(n_stand_ins));
  }

  /// What a node's nearest point is away at least, and how many are to be asked.
  void survey(ShellVisit& visit) const {
    const ShellNode& node = shell.nodes[visit.node];
    const std::span low = std::span(coherence->low).subspan(node.first, node.count);
    const double least = cut_of(visit.node) + coherence->slack + kRounding;
    visit.to_ask = 0;
    double nearest = kInfinite;
    for (const double end : low) {
      visit.to_ask += end < least ? 1 : 0;
      nearest = std::min(nearest, end);
    }
    visit.distance = nearest - coherence->slack;
  }

  /// 0: it may touch; the others by how near they may be.
  size_t rank_of(double distance) const {
    if (!(distance >= query.touch)) return 0;
    const double share = (distance - query.touch) / (query.reach - query.touch);
    return 1 + static_cast<size_t>(std::clamp(share, 0.0, 1.0) * (kRanks - 2));
  }

  /// A node without a point that may be within reach is free as long as they are.
  void note_free(uint32_t index) {
    const ShellNode& node = shell.nodes[index];
    const auto first = coherence->low.begin() + node.first;
    const double least = *std::min_element(first, first + node.count) - coherence->slack;
    coherence->free_until[index] = coherence->wear + (least - query.reach) / kSteepest;
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
    if (coherence == nullptr) return;
    for (size_t k = 0; k < points.at.n; ++k) {
      coherence->low[points.points[k]] = low_end(field, points.at.found(k)) + coherence->slack;
    }
  }

  /// Tells of the points of a patch that touch, and of the nearest of the others.
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
    if (nearest.distance > patch.cut && node.count + reserved <= budget_left()) {
      return look_again(patch.node);
    }
    if (coherence != nullptr) coherence->high[patch.node] = nearest.distance - coherence->slack;
    for (size_t k = patch.begin; touching && k < patch.end; ++k) {
      const double distance = points.at.distance[k];
      if (!(distance < std::min(query.touch, query.reach))) continue;
      if (answer.n == touches.size()) return false;
      touches[answer.n++] = {points.points[k], 1, distance};
    }
    if (!(nearest.distance < query.reach)) return true;
    if (answer.n == touches.size()) return false;
    touches[answer.n++] = nearest;
    return true;
  }

  /// The nearest before has gone, or touches: any other may be it.
  bool look_again(uint32_t index) {
    PointBatch again;
    gather_points(shell.nodes[index], query.reach, again);
    look_up_points(again);
    return tell_of({index, 0, again.at.n, query.reach}, again);
  }

  uint32_t budget_left() const { return query.budget - std::min(query.budget, answer.tested); }

  /// How many points of these nodes are to be asked; no further than the budget.
  uint32_t points_to_ask(std::span<const ShellVisit> nodes) const {
    uint32_t n = 0;
    PointBatch may_be_near;
    for (size_t i = 0; i < nodes.size() && n <= budget_left(); ++i) {
      gather_points(shell.nodes[nodes[i].node], cut_of(nodes[i].node), may_be_near);
      n += static_cast<uint32_t>(std::exchange(may_be_near.at.n, 0));
    }
    return n;
  }

  bool affords_points(std::span<const ShellVisit> nodes) const {
    return shell.x.size() <= budget_left() || points_to_ask(nodes) <= budget_left();
  }

  /// Whether the next level, below these nodes, is within the budget.
  bool affords_nodes(std::span<const ShellVisit> nodes) const {
    uint32_t n = answer.tested;
    const size_t next = answer.level + 1;
    if (shell.levels[next + 1] - shell.levels[next] <= budget_left()) return true;
    for (const ShellVisit& visit : nodes) n += children_to_ask(shell.nodes[visit.node]);
    return n <= query.budget;
  }

  /// Tells of nodes, of which each stands for all below; those that were kept without are looked up
  /// first, as far as the budget goes.
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

  /// The points below patches, or as many as the budget allows.
  void finish_at_patches(std::span<ShellVisit> nodes) {
    if (affords_points(nodes)) {
      answer.is_complete = ask_all_points(nodes);
      answer.level = shell.levels.size() - 2;
      return;
    }
    answer.is_complete = false;
    if (coherence == nullptr || budget_left() < nodes.size()) {
      tell_of_nodes(nodes);
    } else {
      ask_nearest_points(nodes);
    }
  }
};

}  // namespace

ShellCoherence::ShellCoherence(const Pointshell& shell)
    : free_until(shell.nodes.size(), 0), low(shell.x.size(), 0), high(shell.nodes.size(), 0) {
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
  Search search{field, shell, X_OT, query, coherence, visited, touches, {}, 0, {}, {}, 0, {}, 0, 0};
  ShellAnswer& answer = search.answer;
  const size_t last = shell.levels.size() - 2;  // the points
  if (!search.is_free(0)) search.visit(0);
  search.finish_nodes();
  // level by level, the nodes that nothing keeps from being looked into
  for (size_t begin = 0; begin < search.n_visited; ++answer.level) {
    const size_t end = search.n_visited;
    const std::span<ShellVisit> nodes = visited.subspan(begin, end - begin);
    if (answer.level + kPatchLevels >= last) {
      search.finish_at_patches(nodes);
      break;
    }
    // a level is begun only where it can be ended
    if (!search.affords_nodes(nodes)) {
      search.tell_of_nodes(nodes);
      answer.is_complete = false;
      break;
    }
    search.ask_nodes(nodes);
    begin = end;
  }
  return answer;
}

}  // namespace haptic
