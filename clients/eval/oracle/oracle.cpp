// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/eval/oracle/oracle.h"

#include <algorithm>

#include "clients/eval/oracle/walls.h"

namespace haptic {
namespace {

constexpr int kOracleSweeps = 4000;         // limit of sweeps per tick
constexpr long double kStandOff = 1e-12L;   // [m]; a sweep stops this far before a facet
constexpr long double kStill = 1e-15L;      // [m]; a shorter step is no progress
constexpr long double kEdgeSlack = 1e-16L;  // [m]; facets are this much larger: no cracks

}  // namespace

void GodObjectOracle::seed(const Vec3& p_O) {
  g_ = widened(p_O);
}

GodObjectOracle::Stop GodObjectOracle::first_stop(const Long3& from, const Long3& to) const {
  Stop first;
  const Long3 d = to - from;
  const long double length = norm(d);
  for (const uint32_t t : near_) {
    const Facet& f = facets_[t];
    const long double drop = -dot(f.normal, d);
    if (!(drop > 0)) continue;
    const long double height = dot(f.normal, from - f.a);
    if (height < -kEdgeSlack || height > drop) continue;
    // the line passes every edge on the inner side; volume divided by lengths is a distance
    const Long3 a = f.a - from, b = f.b - from, c = f.c - from;
    const auto outside = [&](const Long3& p, const Long3& q) {
      return dot(d, cross(p, q)) > kEdgeSlack * length * norm(q - p);
    };
    if (outside(a, b) || outside(b, c) || outside(c, a)) continue;
    const long double at = std::max(height, 0.0L) / drop;
    if (first.facet == nullptr || at < first.t) first = {&f, at};
  }
  return first;
}

OracleAnswer GodObjectOracle::follow(const Vec3& tool_O) {
  const Long3 tool = widened(tool_O);
  constexpr double kBallSlack = 1e-9;
  near_ = facets_.within(tool_O, static_cast<double>(norm(tool - g_)) + kBallSlack);
  std::vector<const Facet*> stops;  // facets that stopped it at its present place
  Long3 goal = tool;
  OracleAnswer answer;
  // the exact minimum over the planes of `stops`: outside the stand-off, but never lifted off
  const auto minimum = [&](long double stand_off) {
    std::vector<Wall> walls;
    for (const Facet* f : stops) {
      const long double height = dot(f->normal, g_ - f->a);
      walls.push_back({f->normal, std::min(stand_off, height) - height});
    }
    return nearest_in(walls, tool - g_);
  };
  for (;; ++answer.sweeps) {
    if (answer.sweeps == kOracleSweeps) {
      answer.converged = false;
      break;
    }
    const Stop stop = first_stop(g_, goal);
    Long3 reached = goal;
    if (stop.facet != nullptr) {
      const Long3 d = goal - g_;
      const long double height = dot(stop.facet->normal, g_ - stop.facet->a);
      const long double t = (height - kStandOff) / -dot(stop.facet->normal, d);
      reached = g_ + std::clamp(t, 0.0L, stop.t) * d;
    }
    const bool moved = norm(reached - g_) > kStill;
    g_ = reached;
    if (stop.facet == nullptr && (stops.empty() || !moved)) break;
    // planes are valid only where they were met
    if (moved) {
      stops.clear();
      goal = tool;
      continue;
    }
    stops.push_back(stop.facet);
    const std::optional<NearestInWalls> next = minimum(kStandOff);
    if (!next) {
      answer.converged = false;
      break;
    }
    goal = g_ + next->y;
    if (norm(next->y) <= kStill) break;
  }
  const std::optional<NearestInWalls> on_surface = minimum(0);
  if (!on_surface) answer.converged = false;
  const Long3 proxy = on_surface ? g_ + on_surface->y : g_;
  answer.n_active = on_surface ? static_cast<int>(on_surface->n_active) : 0;
  answer.proxy_O = rounded(proxy);
  return answer;
}

}  // namespace haptic
