// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/shell_in_field.h"

#include <algorithm>
#include <limits>

namespace haptic {
namespace {

// twice half the diagonal of a cell: an interpolation of distances is off by no more, nor is the
// rounding of what is stored
constexpr double kFieldError = 1.74;

/// Upper bound of how far any point of the shell went between two poses.
double travel_between(const Pose& before, const Pose& after, double radius) {
  return norm(after.p - before.p) +
         radius * norm(to_rotation_vector(after.q * conjugate(before.q)));
}

void note_travel(const Pointshell& shell, const Pose& X_OT, double reach,
                 ShellCoherence& coherence) {
  if (coherence.is_fresh || coherence.reach != reach) {
    std::fill(coherence.free_until.begin(), coherence.free_until.end(), 0.0);
    coherence.travel = 0;
    coherence.is_fresh = false;
    coherence.reach = reach;
  } else {
    // a little more, for what the sum rounds away
    coherence.travel += travel_between(coherence.X_OT, X_OT, shell.radius) * (1 + 1e-12) + 1e-15;
  }
  coherence.X_OT = X_OT;
}

/// One level of the search under way.
struct Search {
  const DistanceField& field;
  const Pointshell& shell;
  Pose X_OT;
  const ShellQuery& query;
  ShellCoherence* coherence;
  double slack;  // [m]
  ShellAnswer answer;

  double distance_of(uint32_t point) {
    ++answer.tested;
    const Vec3 p_T{static_cast<double>(shell.x[point]), static_cast<double>(shell.y[point]),
                   static_cast<double>(shell.z[point])};
    return sample_field(field, X_OT * p_T).distance;
  }

  /// Whether anything below a node may be within reach; then how far its point is as well.
  bool may_touch(uint32_t index, ShellVisit& visit) {
    if (coherence != nullptr && coherence->travel < coherence->free_until[index]) return false;
    const ShellNode& node = shell.nodes[index];
    const double distance = distance_of(node.point);
    // between nodes the field is off by what fits between them, at this point and at those below
    const double clear = distance - static_cast<double>(node.radius) - query.reach - slack;
    if (clear > 0 && coherence != nullptr) coherence->free_until[index] = coherence->travel + clear;
    visit = {index, distance};
    return clear <= 0;
  }
};

/// A node is free as long as all its children are; those looked into last are not.
void note_free(const Pointshell& shell, std::span<const ShellVisit> visited, size_t first_last,
               ShellCoherence& coherence) {
  for (size_t i = visited.size(); i-- > 0;) {
    const ShellNode& node = shell.nodes[visited[i].node];
    double free_until = i < first_last ? std::numeric_limits<double>::infinity() : 0;
    for (uint32_t k = 0; i < first_last && k < node.n_children; ++k) {
      free_until = std::min(free_until, coherence.free_until[node.first_child + k]);
    }
    coherence.free_until[visited[i].node] = free_until;
  }
}

}  // namespace

ShellAnswer find_touches(const DistanceField& field, const Pointshell& shell, const Pose& X_OT,
                         const ShellQuery& query, ShellCoherence* coherence,
                         std::span<ShellVisit> visited, std::span<ShellTouch> touches) {
  if (shell.nodes.empty() || field.index.empty() || visited.size() < shell.nodes.size()) return {};
  if (coherence != nullptr) note_travel(shell, X_OT, query.reach, *coherence);
  const double slack = kFieldError * field.cell;
  Search search{field, shell, X_OT, query, coherence, slack, {}};
  ShellAnswer& answer = search.answer;
  const size_t last = shell.levels.size() - 2;
  // level by level, the nodes that nothing keeps from being looked into
  size_t begin = 0, end = 0;
  if (search.may_touch(0, visited[0])) end = 1;
  for (; answer.level < last && begin < end; ++answer.level) {
    size_t children = 0;
    for (size_t i = begin; i < end; ++i) children += shell.nodes[visited[i].node].n_children;
    // a level is begun only where it can be ended
    if (answer.tested + children > query.budget) {
      answer.is_complete = false;
      break;
    }
    const size_t next = end;
    for (size_t i = begin; i < next; ++i) {
      const ShellNode& node = shell.nodes[visited[i].node];
      for (uint32_t k = 0; k < node.n_children; ++k) {
        // a node that is not looked into leaves its place to the next
        if (search.may_touch(node.first_child + k, visited[end])) ++end;
      }
    }
    begin = next;
  }
  for (size_t i = begin; i < end; ++i) {
    const ShellNode& node = shell.nodes[visited[i].node];
    const double distance = visited[i].distance;
    if (!(distance < query.reach)) continue;
    if (answer.n == touches.size()) {
      answer.is_complete = false;
      break;
    }
    touches[answer.n++] = {node.point, node.count, distance};
  }
  if (coherence != nullptr) note_free(shell, visited.first(end), begin, *coherence);
  return answer;
}

}  // namespace haptic
