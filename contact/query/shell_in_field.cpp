// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/shell_in_field.h"

#include <algorithm>
#include <limits>

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

  bool is_free(uint32_t index) const {
    return coherence != nullptr && coherence->travel < coherence->free_until[index];
  }

  /// Whether most of a node's children are free though it is not: then the others are asked in its
  /// place, which has been in vain before.
  bool has_few_to_ask(const ShellNode& node) const {
    if (coherence == nullptr) return false;
    uint32_t to_ask = 0;
    for (uint32_t k = 0; k < node.n_children; ++k) to_ask += is_free(node.first_child + k) ? 0 : 1;
    return kFewOf * to_ask <= node.n_children && node.n_children > 0;
  }

  /// Has a node looked up, together with those that come next, or kept as it is.
  void visit(uint32_t index) {
    if (is_free(index)) return;
    const ShellNode& node = shell.nodes[index];
    const bool is_asked = !has_few_to_ask(node);
    candidates[n_candidates++] = {index, is_asked};
    if (is_asked) put_in_batch(node.point);
    if (n_candidates == candidates.size()) finish_batch();
  }

  void put_in_batch(uint32_t point) {
    batch.x[batch.n] = shell.x[point];
    batch.y[batch.n] = shell.y[point];
    batch.z[batch.n] = shell.z[point];
    ++batch.n;
  }

  /// Keeps of the candidates what may have anything within reach.
  void finish_batch() {
    look_up(field, X_OT, batch);
    size_t asked = 0;
    for (const auto& [index, is_asked] : std::span(candidates.data(), n_candidates)) {
      if (!is_asked) {
        visited[n_visited++] = {index, kNotAsked};
        continue;
      }
      const FieldDistance& at = batch.found[asked++];
      const double clear =
          way_to(query.reach, at, field.cell) - static_cast<double>(shell.nodes[index].radius);
      const bool is_clear = clear > 0;
      // which are clear cannot be foretold: written in any case, counted where it is kept
      visited[n_visited] = {index, at.distance};
      n_visited += is_clear ? 0 : 1;
      if (coherence != nullptr) {
        coherence->free_until[index] = is_clear ? coherence->travel + clear : 0;
      }
    }
    answer.tested += static_cast<uint32_t>(batch.n);
    batch.n = n_candidates = 0;
  }

  /// Looks up what was kept without: the search ends with it.
  void ask_all(std::span<ShellVisit> kept) {
    for (ShellVisit& visit : kept) {
      if (visit.distance != kNotAsked) continue;
      put_in_batch(shell.nodes[visit.node].point);
      look_up(field, X_OT, batch);
      visit.distance = batch.found[0].distance;
      ++answer.tested;
      batch.n = 0;
    }
  }
};

/// A node that was looked into is free as long as all its children are.
void note_free(const Pointshell& shell, std::span<const ShellVisit> looked_into,
               ShellCoherence& coherence) {
  for (size_t i = looked_into.size(); i-- > 0;) {
    const ShellNode& node = shell.nodes[looked_into[i].node];
    double free_until = std::numeric_limits<double>::infinity();
    for (uint32_t k = 0; k < node.n_children; ++k) {
      free_until = std::min(free_until, coherence.free_until[node.first_child + k]);
    }
    coherence.free_until[looked_into[i].node] = free_until;
  }
}

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
  Search search{field, shell, X_OT, query, coherence, visited, {}, 0, {}, {}, 0};
  ShellAnswer& answer = search.answer;
  const size_t last = shell.levels.size() - 2;
  // level by level, the nodes that nothing keeps from being looked into
  size_t begin = 0;
  search.visit(0);
  search.finish_batch();
  for (; answer.level < last && begin < search.n_visited; ++answer.level) {
    const size_t end = search.n_visited;
    size_t children = 0;
    for (size_t i = begin; i < end; ++i) children += shell.nodes[visited[i].node].n_children;
    // a level is begun only where it can be ended
    if (answer.tested + children > query.budget) {
      answer.is_complete = false;
      search.ask_all(visited.subspan(begin, end - begin));
      break;
    }
    for (size_t i = begin; i < end; ++i) {
      const ShellNode& node = shell.nodes[visited[i].node];
      for (uint32_t k = 0; k < node.n_children; ++k) search.visit(node.first_child + k);
    }
    search.finish_batch();
    begin = end;
  }
  const std::span<const ShellVisit> finest = visited.subspan(begin, search.n_visited - begin);
  for (const ShellVisit& visit : finest) {
    if (!(visit.distance < query.reach)) continue;
    if (answer.n == touches.size()) {
      answer.is_complete = false;
      break;
    }
    const ShellNode& node = shell.nodes[visit.node];
    touches[answer.n++] = {node.point, node.count, visit.distance};
  }
  if (coherence != nullptr) note_free(shell, visited.first(begin), *coherence);
  return answer;
}

}  // namespace haptic
