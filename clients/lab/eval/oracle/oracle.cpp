// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/oracle/oracle.h"

#include <algorithm>

#include "contact/query/triangle/closest_on_triangle.h"

namespace haptic {
namespace {

constexpr int kOracleSweeps = 4000;  // limit of sweeps per tick
constexpr long double kWay = 1e-9L;  // [m]; a shorter way away from a vertex is rounding

}  // namespace

OracleAnswer& ProxyOracle::place(OracleAnswer& answer,
                                 const std::optional<NearestInWalls>& on_surface) const {
  if (!on_surface) answer.converged = false;
  answer.proxy_O = rounded(on_surface ? g_ + on_surface->y : g_);
  answer.n_active = on_surface ? static_cast<int>(on_surface->n_active) : 0;
  return answer;
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

/// The end of the sweep towards the goal: kStandOff before the facet that stops it.
Long3 GodObjectOracle::reached_towards(const Long3& goal, const Stop& stop) const {
  if (stop.facet == nullptr) return goal;
  const Long3 d = goal - g_;
  const long double height = dot(stop.facet->normal, g_ - stop.facet->a);
  const long double t = (height - kStandOff) / -dot(stop.facet->normal, d);
  return g_ + std::clamp(t, 0.0L, stop.t) * d;
}

/// The exact minimum over these planes, from g: outside the stand-off, but never lifted off.
std::optional<NearestInWalls> GodObjectOracle::nearest_on(const std::vector<const Facet*>& planes,
                                                          const Long3& tool,
                                                          long double stand_off) const {
  std::vector<Wall> walls;
  for (const Facet* f : planes) {
    const long double height = dot(f->normal, g_ - f->a);
    walls.push_back({f->normal, std::min(stand_off, height) - height});
  }
  return nearest_in(walls, tool - g_);
}

std::vector<const Facet*> GodObjectOracle::touched() const {
  std::vector<const Facet*> touched;
  const Vec3 here = rounded(g_);
  for (const uint32_t t : near_) {
    const Vec3 nearest_O = closest_on_triangle(facets_.mesh(), t, here).point;
    if (norm(nearest_O - here) <= kTouch) touched.push_back(&facets_[t]);
  }
  return touched;
}

/// Takes the steepest of the free ways along one or two of the facets that it touches; false: there
/// is none.
bool GodObjectOracle::leave(const Long3& tool) {
  const std::vector<const Facet*> around = touched();
  long double steepest = 0;
  Long3 end = g_;
  const auto try_along = [&](const std::vector<const Facet*>& planes) {
    const std::optional<NearestInWalls> next = nearest_on(planes, tool, kStandOff);
    if (!next || norm(next->y) <= kWay) return;
    const long double reach = dot(tool - g_, normalized(next->y));
    if (reach <= steepest) return;
    const Long3 goal = g_ + next->y;
    const Long3 reached = reached_towards(goal, first_stop(g_, goal));
    if (norm(reached - g_) <= kWay) return;
    steepest = reach;
    end = reached;
  };
  for (size_t i = 0; i < around.size(); ++i) {
    try_along({around[i]});
    for (size_t k = 0; k < i; ++k) try_along({around[i], around[k]});
  }
  g_ = end;
  return steepest > 0;
}

OracleAnswer GodObjectOracle::follow(const Vec3& tool_O) {
  const Long3 tool = widened<long double>(tool_O);
  constexpr double kBallSlack = 1e-9;
  near_ = facets_.within(tool_O, static_cast<double>(norm(tool - g_)) + kBallSlack);
  std::vector<const Facet*> stops;  // facets that stopped it at its present place
  Long3 goal = tool;
  OracleAnswer answer;
  for (;; ++answer.sweeps) {
    if (answer.sweeps == kOracleSweeps) {
      answer.converged = false;
      break;
    }
    const Stop stop = first_stop(g_, goal);
    const Long3 reached = reached_towards(goal, stop);
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
    const std::optional<NearestInWalls> next = nearest_on(stops, tool, kStandOff);
    if (!next) {
      answer.converged = false;
      break;
    }
    goal = g_ + next->y;
    if (norm(next->y) > kStill) continue;
    if (!leave(tool)) break;
    answer.has_left = true;
    stops.clear();
    goal = tool;
  }
  return place(answer, nearest_on(stops, tool, 0));
}

}  // namespace haptic
