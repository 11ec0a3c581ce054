// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/oracle/sphere_oracle.h"

#include <algorithm>
#include <array>

#include "clients/lab/eval/oracle/walls.h"

namespace haptic {
namespace {

using Obstacle = SphereOracle::Obstacle;
using Kind = Obstacle::Kind;

constexpr int kSphereSweeps = 2000;         // limit of sweeps per tick
constexpr size_t kMostStops = 24;           // obstacles met at one place; sound meshes have a few
constexpr int kNewtonSteps = 20;            // limit; it converges in a few
constexpr long double kNearRest = 1e-6L;    // [m]; after a shorter step Newton's method is tried
constexpr long double kLastRoll = 0.1L;     // of the radius; farther solutions are rejected
constexpr long double kSolved = 1e-17L;     // [m]; convergence of Newton's method
constexpr long double kRoomSlack = 1e-18L;  // [m]; rounding of distances
constexpr double kBallSlack = 1e-9;         // [m]; rounding of bounding balls

/// Vector to x from the nearest point of the obstacle's whole plane, line or point.
Long3 away_from(const Obstacle& o, const Long3& x) {
  const Long3 m = x - o.point;
  if (o.kind == Kind::kVertex) return m;
  const Long3 along = dot(m, o.direction) * o.direction;
  return o.kind == Kind::kFace ? along : m - along;
}

/// Earliest t in [0, 1] at which |m + t d| falls to the radius.
std::optional<long double> time_to_ball(const Long3& m, const Long3& d, long double radius) {
  const long double approach = -dot(m, d), c = dot(m, m) - radius * radius;
  if (!(approach > 0)) return std::nullopt;
  if (c <= 0) return 0.0L;
  const long double reach = approach * approach - dot(d, d) * c;
  if (reach < 0) return std::nullopt;
  const long double t = c / (approach + std::sqrt(reach));
  return t <= 1 ? std::optional(t) : std::nullopt;
}

/// When the centre comes within `radius` of the whole plane, line or point of an obstacle.
std::optional<long double> time_to(const Obstacle& o, const Long3& from, const Long3& d,
                                   long double radius) {
  const Long3 m = from - o.point;
  const long double across = dot(m, o.direction), speed = dot(d, o.direction);
  if (o.kind == Kind::kVertex) return time_to_ball(m, d, radius);
  if (o.kind == Kind::kEdge) {
    return time_to_ball(m - across * o.direction, d - speed * o.direction, radius);
  }
  const long double drop = across < 0 ? speed : -speed;
  if (!(drop > 0)) return std::nullopt;
  const long double t = std::max(std::fabs(across) - radius, 0.0L) / drop;
  return t <= 1 ? std::optional(t) : std::nullopt;
}

bool lies_over(const Facet& f, const Long3& x) {
  const auto outside = [&](const Long3& p, const Long3& q) {
    return dot(f.normal, cross(q - p, x - p)) < -kEdgeSlack * norm(q - p);
  };
  const bool has_area = dot(f.normal, f.normal) > 0;
  return has_area && !outside(f.a, f.b) && !outside(f.b, f.c) && !outside(f.c, f.a);
}

long double distance_from(const Facet& f, const Long3& x) {
  if (lies_over(f, x)) return std::fabs(dot(f.normal, x - f.a));
  const auto from_side = [&](const Long3& p, const Long3& q) {
    const Long3 side = q - p;
    const long double length2 = dot(side, side);
    const long double share = length2 > 0 ? dot(x - p, side) / length2 : 0;
    return norm(x - (p + std::clamp(share, 0.0L, 1.0L) * side));
  };
  return std::min({from_side(f.a, f.b), from_side(f.b, f.c), from_side(f.c, f.a)});
}

/// Unknowns of the minimum: position and multiplier of each obstacle.
struct Rest {
  Long3 x;
  std::array<long double, 3> push{};
};

/// Solves a y = b with partial pivoting, y overwriting b; false if a is singular.
bool solve(size_t n, std::array<std::array<long double, 6>, 6>& a, std::array<long double, 6>& b) {
  for (size_t k = 0; k < n; ++k) {
    size_t pivot = k;
    for (size_t i = k + 1; i < n; ++i) {
      if (std::fabs(a[i][k]) > std::fabs(a[pivot][k])) pivot = i;
    }
    if (!(std::fabs(a[pivot][k]) > 1e-15L)) return false;
    std::swap(a[k], a[pivot]);
    std::swap(b[k], b[pivot]);
    for (size_t i = k + 1; i < n; ++i) {
      const long double share = a[i][k] / a[k][k];
      for (size_t j = k; j < n; ++j) a[i][j] -= share * a[k][j];
      b[i] -= share * b[k];
    }
  }
  for (size_t k = n; k-- > 0;) {
    for (size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return true;
}

/// Second derivative of the distance from an obstacle along u and v, at x.
long double bend(const Obstacle& o, const Long3& x, const Long3& u, const Long3& v) {
  if (o.kind == Kind::kFace) return 0;
  const Long3 away = away_from(o, x);
  const long double distance = norm(away);
  const Long3 g = (1 / distance) * away;
  long double flat = dot(u, v) - dot(u, g) * dot(v, g);
  if (o.kind == Kind::kEdge) flat -= dot(u, o.direction) * dot(v, o.direction);
  return flat / distance;
}

/// Second derivative of ½|x − tool|² − Σ λ_i (d_i − radius).
long double curvature(std::span<const Obstacle> pushing, const Rest& rest, const Long3& u,
                      const Long3& v) {
  long double sum = dot(u, v);
  for (size_t i = 0; i < pushing.size(); ++i) {
    sum -= rest.push[i] * bend(pushing[i], rest.x, u, v);
  }
  return sum;
}

constexpr std::array<Long3, 3> kAxes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// Newton's method on x − tool = Σ λ_i ∇d_i(x), d_i(x) = radius.
std::optional<Rest> newton(std::span<const Obstacle> pushing, const Long3& from, const Long3& tool,
                           long double radius) {
  Rest rest{from, {}};
  const size_t n = 3 + pushing.size();
  for (int step = 0; step < kNewtonSteps; ++step) {
    std::array<std::array<long double, 6>, 6> a{};
    std::array<long double, 6> b{};
    const Long3 pull = tool - rest.x;
    for (size_t i = 0; i < 3; ++i) {
      b[i] = dot(kAxes[i], pull);
      for (size_t j = 0; j < 3; ++j) a[i][j] = curvature(pushing, rest, kAxes[i], kAxes[j]);
    }
    for (size_t k = 0; k < pushing.size(); ++k) {
      const Long3 away = away_from(pushing[k], rest.x);
      const long double distance = norm(away);
      if (!(distance > 0)) return std::nullopt;
      const Long3 g = (1 / distance) * away;
      b[3 + k] = radius - distance;
      for (size_t i = 0; i < 3; ++i) {
        a[3 + k][i] = dot(kAxes[i], g);
        // solves for the new λ itself, not its change, so that no initial λ is needed
        a[i][3 + k] = -a[3 + k][i];
      }
    }
    if (!solve(n, a, b)) return std::nullopt;
    const Long3 way{b[0], b[1], b[2]};
    rest.x = rest.x + way;
    for (size_t k = 0; k < pushing.size(); ++k) rest.push[k] = b[3 + k];
    if (norm(way) <= kSolved) return rest;
  }
  return std::nullopt;
}

/// True if a solution of Newton's method is a minimum: every obstacle pushes, and the curvature
/// along them is positive.
bool is_minimum(std::span<const Obstacle> pushing, const Rest& rest) {
  for (size_t i = 0; i < pushing.size(); ++i) {
    if (!(rest.push[i] > 0)) return false;
  }
  if (pushing.size() == 3) return true;
  const Long3 g0 = normalized(away_from(pushing[0], rest.x));
  if (pushing.size() == 2) {
    const Long3 u = cross(g0, normalized(away_from(pushing[1], rest.x)));
    return curvature(pushing, rest, u, u) > 0;
  }
  const Long3 u = normalized(cross(g0, std::fabs(g0.x) < 0.6L ? kAxes[0] : kAxes[1]));
  const Long3 v = cross(g0, u);
  const long double uu = curvature(pushing, rest, u, u), vv = curvature(pushing, rest, v, v),
                    uv = curvature(pushing, rest, u, v);
  return uu > 0 && uu * vv > uv * uv;
}

}  // namespace

SphereOracle::SphereOracle(const FacetBins& facets, double radius)
    : ProxyOracle(facets), radius_(radius) {
  const TriangleMesh& mesh = facets.mesh();
  std::vector<bool> taken(mesh.vertices.size(), false);
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    uint32_t owned = 0;
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t vertex = mesh.triangles[t][i];
      if (mesh.edge_faces[mesh.triangle_edges[t][i]][0] == t) owned |= 1u << i;
      if (!taken[vertex]) owned |= 8u << i;
      taken[vertex] = true;
    }
    owned_.push_back(static_cast<uint8_t>(owned));
  }
}

std::unique_ptr<ProxyOracle> make_oracle(const FacetBins& facets, double radius) {
  if (radius > 0) return std::make_unique<SphereOracle>(facets, radius);
  return std::make_unique<GodObjectOracle>(facets);
}

void SphereOracle::stop_at_facet(uint32_t triangle, const Long3& from, const Long3& d,
                                 Stop& first) const {
  const Facet& f = facets_[triangle];
  const auto take = [&](const Obstacle& o, long double t) {
    if (!first.obstacle || t < first.t) first = {o, t};
  };
  const Obstacle face{Kind::kFace, f.a, f.normal, triangle};
  if (const auto t = time_to(face, from, d, radius_); t && lies_over(f, from + *t * d)) {
    take(face, *t);
  }
  const std::array<Long3, 3> corners{f.a, f.b, f.c};
  for (size_t i = 0; i < 3; ++i) {
    const Long3& p = corners[i];
    if ((owned_[triangle] & (1u << i)) != 0) {
      const Long3 side = corners[(i + 1) % 3] - p;
      const Obstacle edge{Kind::kEdge, p, normalized(side), triangle};
      const auto t = time_to(edge, from, d, radius_);
      const long double where = t ? dot(from + *t * d - p, edge.direction) : -1;
      if (where >= 0 && where <= norm(side)) take(edge, *t);
    }
    if ((owned_[triangle] & (8u << i)) != 0) {
      const Obstacle vertex{Kind::kVertex, p, {}, triangle};
      if (const auto t = time_to(vertex, from, d, radius_)) take(vertex, *t);
    }
  }
}

SphereOracle::Stop SphereOracle::first_stop(const Long3& from, const Long3& to) const {
  Stop first;
  const Long3 d = to - from;
  if (!near_.empty()) stop_at_facet(recent_, from, d, first);
  // bounding ball of the remaining path
  Vec3 middle_O;
  double reach = 0;
  const auto narrow = [&] {
    middle_O = rounded(from + (0.5L * first.t) * d);
    reach = static_cast<double>(radius_ + 0.5L * first.t * norm(d)) + kBallSlack;
  };
  narrow();
  for (const uint32_t triangle : near_) {
    const Facet& f = facets_[triangle];
    const double far = reach + f.reach;
    if (norm_squared(f.middle_O - middle_O) > far * far) continue;
    const long double before = first.t;
    stop_at_facet(triangle, from, d, first);
    if (first.t < before) narrow();
  }
  if (first.obstacle) recent_ = first.obstacle->triangle;
  return first;
}

bool SphereOracle::has_room(const Long3& x) const {
  const Vec3 x_O = rounded(x);
  return std::all_of(near_.begin(), near_.end(), [&](uint32_t triangle) {
    const Facet& f = facets_[triangle];
    const double far = static_cast<double>(radius_) + f.reach + kBallSlack;
    return norm_squared(f.middle_O - x_O) > far * far ||
           distance_from(f, x) >= radius_ - kRoomSlack;
  });
}

std::optional<Long3> SphereOracle::rest_on(std::span<const Obstacle> pushing, const Long3& from,
                                           const Long3& tool) const {
  const std::optional<Rest> rest = newton(pushing, from, tool, radius_);
  if (!rest || norm(rest->x - from) > kLastRoll * radius_ || !is_minimum(pushing, *rest)) {
    return std::nullopt;
  }
  // planes and lines extend beyond their facet: the solution must touch the facet itself
  for (const Obstacle& o : pushing) {
    if (distance_from(facets_[o.triangle], rest->x) > radius_ + kRoomSlack) return std::nullopt;
  }
  return has_room(rest->x) ? std::optional(rest->x) : std::nullopt;
}

Long3 SphereOracle::swept_to(const Stop& stop, const Long3& goal) const {
  if (!stop.obstacle) return goal;
  const Long3 d = goal - g_;
  const auto t = time_to(*stop.obstacle, g_, d, radius_ + kStandOff);
  return g_ + std::min(t.value_or(0), stop.t) * d;
}

std::optional<NearestInWalls> SphereOracle::minimum_over(std::span<const Obstacle> stops,
                                                         const Long3& tool,
                                                         long double stand_off) const {
  std::vector<Wall> walls;
  for (const Obstacle& o : stops) {
    const Long3 away = away_from(o, g_);
    const long double height = norm(away) - radius_;
    walls.push_back({normalized(away), std::min(stand_off, height) - height});
  }
  return nearest_in(walls, tool - g_);
}

OracleAnswer SphereOracle::follow(const Vec3& tool_O) {
  const Long3 tool = widened<long double>(tool_O);
  const auto ball = static_cast<double>(norm(tool - g_) + radius_) + kBallSlack;
  near_ = facets_.within(tool_O, ball);
  std::vector<Obstacle> stops;    // obstacles that stopped it at its present place
  std::vector<Obstacle> pushing;  // those the goal lies on
  Long3 goal = tool;
  OracleAnswer answer;
  for (;; ++answer.sweeps) {
    if (answer.sweeps == kSphereSweeps) {
      answer.converged = false;
      break;
    }
    const Stop stop = first_stop(g_, goal);
    const Long3 reached = swept_to(stop, goal);
    const bool moved = norm(reached - g_) > kStill;
    if (!stop.obstacle && stops.empty()) {
      g_ = reached;
      answer.proxy_O = tool_O;
      return answer;
    }
    // near the end, the path becomes an infinite sequence of ever shorter steps
    if (!stop.obstacle && norm(goal - g_) < kNearRest) {
      if (const std::optional<Long3> rest = rest_on(pushing, reached, tool)) {
        g_ = reached;
        answer.proxy_O = rounded(*rest);
        answer.n_active = static_cast<int>(pushing.size());
        return answer;
      }
    }
    g_ = reached;
    if (!stop.obstacle && !moved) break;
    if (moved) {
      stops.clear();
      goal = tool;
      continue;
    }
    // no way out of an overlap, as in a broken mesh
    if (stops.size() == kMostStops) {
      answer.converged = false;
      break;
    }
    stops.push_back(*stop.obstacle);
    const std::optional<NearestInWalls> next = minimum_over(stops, tool, kStandOff);
    if (!next) {
      answer.converged = false;
      break;
    }
    pushing.clear();
    for (size_t i = 0; i < next->n_active; ++i) pushing.push_back(stops[next->active[i]]);
    goal = g_ + next->y;
  }
  return place(answer, minimum_over(stops, tool, 0));
}

}  // namespace haptic
