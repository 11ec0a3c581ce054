// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/eval_oracle.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "contact/query/closest_point.h"

namespace haptic {
namespace {

constexpr int kOracleSweeps = 4000;
constexpr long double kStandOff = 1e-12L;   // [m]
constexpr long double kStill = 1e-15L;      // less is no progress [m]
constexpr long double kEdgeSlack = 1e-16L;  // a facet is so much larger: no crack between two [m]
constexpr long double kFeasible = 1e-17L;   // [m]
constexpr long double kDependent = 1e-13L;  // sine or volume of normals below which they are
constexpr double kMostBins = 128;           // along one axis

Long3 widened(const Vec3& v) {
  return {v.x, v.y, v.z};
}
Vec3 rounded(const Long3& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
Long3 operator+(const Long3& a, const Long3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Long3 operator-(const Long3& a, const Long3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Long3 operator*(long double s, const Long3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
long double dot(const Long3& a, const Long3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Long3 cross(const Long3& a, const Long3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
long double norm(const Long3& a) {
  return std::sqrt(dot(a, a));
}
Long3 normalized(const Long3& a) {
  const long double length = norm(a);
  return length > 0 ? (1 / length) * a : Long3{};
}

/// Half-space n·y ≥ d about the god-object.
struct Wall {
  Long3 normal;
  long double offset = 0;
};

/// Nearest point to q on all the planes of a subset; nothing where they are dependent.
std::optional<Long3> nearest_on(const std::vector<const Wall*>& walls, const Long3& q) {
  const auto gap = [&](size_t i) { return walls[i]->offset - dot(walls[i]->normal, q); };
  const Long3& n0 = walls[0]->normal;
  if (walls.size() == 1) return q + gap(0) * n0;
  const Long3& n1 = walls[1]->normal;
  const Long3 along = cross(n0, n1);
  if (walls.size() == 2) {
    const long double sine2 = dot(along, along);
    if (sine2 < kDependent * kDependent) return std::nullopt;
    return q + (1 / sine2) * (gap(0) * cross(n1, along) + gap(1) * cross(along, n0));
  }
  const Long3& n2 = walls[2]->normal;
  const long double volume = dot(along, n2);
  if (std::fabs(volume) < kDependent) return std::nullopt;
  return q + (1 / volume) * (gap(0) * cross(n1, n2) + gap(1) * cross(n2, n0) + gap(2) * along);
}

struct Nearest {
  Long3 y;
  int n_active = 0;
};

/// min |y − q| over the half-spaces: the nearest feasible one among the Lagrange points of every
/// subset. The minimum is one of them, so no multiplier is needed.
std::optional<Nearest> nearest_in(const std::vector<Wall>& walls, const Long3& q) {
  std::optional<Nearest> best;
  long double best_distance = 0;
  const auto consider = [&](const std::vector<const Wall*>& subset) {
    const std::optional<Long3> y = subset.empty() ? q : nearest_on(subset, q);
    if (!y) return;
    const long double distance = norm(*y - q);
    if (best && distance >= best_distance) return;
    const bool feasible = std::all_of(walls.begin(), walls.end(), [&](const Wall& wall) {
      return dot(wall.normal, *y) - wall.offset >= -kFeasible;
    });
    if (!feasible) return;
    best = {*y, static_cast<int>(subset.size())};
    best_distance = distance;
  };
  consider({});
  for (size_t i = 0; i < walls.size(); ++i) {
    consider({&walls[i]});
    for (size_t j = 0; j < i; ++j) {
      consider({&walls[i], &walls[j]});
      for (size_t k = 0; k < j; ++k) consider({&walls[i], &walls[j], &walls[k]});
    }
  }
  return best;
}

bool is_on_border(const TriangleMesh& mesh, const Feature& feature, uint32_t triangle) {
  if (mesh.closed || feature.kind == FeatureKind::kFace) return false;
  if (feature.kind == FeatureKind::kEdge) return mesh.edge_faces[feature.index][1] == kNoFace;
  const auto& edges = mesh.triangle_edges[triangle];
  return std::any_of(edges.begin(), edges.end(),
                     [&](uint32_t e) { return mesh.edge_faces[e][1] == kNoFace; });
}

}  // namespace

GodObjectOracle::GodObjectOracle(const TriangleMesh& mesh) : mesh_(mesh), lower_(mesh.lower) {
  const Vec3 size = mesh.upper - mesh.lower;
  bin_ = std::max({size.x, size.y, size.z, 1e-9}) / kMostBins;
  for (int axis = 0; axis < 3; ++axis) {
    bins_[static_cast<size_t>(axis)] = static_cast<size_t>(size[axis] / bin_) + 1;
  }
  facets_.reserve(mesh.triangles.size());
  first_in_bin_.assign(bins_[0] * bins_[1] * bins_[2] + 1, 0);
  std::vector<size_t> bin_of;
  for (const auto& [a, b, c] : mesh.triangles) {
    Facet facet{
        widened(mesh.vertices[a]), widened(mesh.vertices[b]), widened(mesh.vertices[c]), {}, {}, 0};
    facet.normal = normalized(cross(facet.b - facet.a, facet.c - facet.a));
    facet.middle_O = rounded((1.0L / 3) * (facet.a + facet.b + facet.c));
    for (const uint32_t v : {a, b, c}) {
      facet.reach = std::max(facet.reach, haptic::norm(mesh.vertices[v] - facet.middle_O));
    }
    reach_ = std::max(reach_, facet.reach);
    const Vec3& m = facet.middle_O;
    bin_of.push_back((bin_along(2, m.z) * bins_[1] + bin_along(1, m.y)) * bins_[0] +
                     bin_along(0, m.x));
    ++first_in_bin_[bin_of.back() + 1];
    facets_.push_back(facet);
  }
  // counting sort
  for (size_t i = 1; i < first_in_bin_.size(); ++i) first_in_bin_[i] += first_in_bin_[i - 1];
  order_.resize(facets_.size());
  std::vector<uint32_t> next = first_in_bin_;
  for (uint32_t t = 0; t < facets_.size(); ++t) order_[next[bin_of[t]]++] = t;
}

size_t GodObjectOracle::bin_along(int axis, double coordinate) const {
  const double last = static_cast<double>(bins_[static_cast<size_t>(axis)] - 1);
  return static_cast<size_t>(std::clamp((coordinate - lower_[axis]) / bin_, 0.0, last));
}

void GodObjectOracle::gather(const Vec3& centre_O, double radius) {
  near_.clear();
  const double far = radius + reach_;
  const auto low = [&](int axis) { return bin_along(axis, centre_O[axis] - far); };
  const auto high = [&](int axis) { return bin_along(axis, centre_O[axis] + far); };
  for (size_t z = low(2); z <= high(2); ++z) {
    for (size_t y = low(1); y <= high(1); ++y) {
      const size_t row = (z * bins_[1] + y) * bins_[0];
      const uint32_t begin = first_in_bin_[row + low(0)], end = first_in_bin_[row + high(0) + 1];
      for (uint32_t i = begin; i < end; ++i) {
        const Facet& facet = facets_[order_[i]];
        if (haptic::norm(facet.middle_O - centre_O) <= radius + facet.reach) {
          near_.push_back(order_[i]);
        }
      }
    }
  }
}

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
    // the line passes each side on the inner side: a volume per length is a distance
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
  gather(tool_O, static_cast<double>(norm(tool - g_)) + kBallSlack);
  std::vector<const Facet*> stops;  // facets that stopped it where it stands
  Long3 goal = tool;
  OracleAnswer answer;
  // the exact minimum over the planes of `stops`: no nearer than that, but never lifted off
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
    // planes hold where they were met: elsewhere the surface is another
    if (moved) {
      stops.clear();
      goal = tool;
      continue;
    }
    stops.push_back(stop.facet);
    const std::optional<Nearest> next = minimum(kStandOff);
    if (!next) {
      answer.converged = false;
      break;
    }
    goal = g_ + next->y;
    if (norm(next->y) <= kStill) break;
  }
  const std::optional<Nearest> on_surface = minimum(0);
  if (!on_surface) answer.converged = false;
  const Long3 proxy = on_surface ? g_ + on_surface->y : g_;
  answer.n_active = on_surface ? on_surface->n_active : 0;
  answer.proxy_O = rounded(proxy);
  return answer;
}

BehindSurface GodObjectOracle::behind(const Vec3& p_O, double max_distance) {
  gather(p_O, max_distance);
  BehindSurface result;
  ClosestPoint nearest;
  nearest.distance = max_distance;
  for (const uint32_t t : near_) {
    const ClosestPoint c = closest_point_on_triangle(mesh_, t, p_O);
    if (c.distance < nearest.distance) nearest = c;
  }
  if (!nearest.found || is_on_border(mesh_, nearest.feature, nearest.triangle)) return result;
  result.is_known = true;
  const Vec3 away = p_O - nearest.point_O;
  if (haptic::dot(away, pseudo_normal(mesh_, nearest.feature)) < 0) result.depth = nearest.distance;
  return result;
}

}  // namespace haptic
