// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point/sphere_rest.h"

#include <Eigen/LU>
#include <array>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kMaxSteps = 12;      // Newton's method needs four to six
constexpr double kSolved = 1e-10;  // of `distance`: the error is about the square of the last step
constexpr double kFarStep = 1.0;   // of `distance`: a longer step has diverged
constexpr size_t kMaxObstacles = 3;  // three fix a point

// at most 3 + 3 unknowns: nothing is allocated
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;

/// One obstacle seen from a place: distance, its gradient, and its curvature.
struct View {
  double distance = 0;
  Vec3 normal_W;
  Vec3 flat_W;  // direction of an edge, along which the distance is constant; else zero
  double bend = 0;
};

View view_from(const RoundObstacle& o, const Vec3& x_W) {
  HAPTIC_ASSERT(o.kind == FeatureKind::kVertex || is_unit(o.direction_W));
  const Vec3 away_W = x_W - o.point_W;
  if (o.kind == FeatureKind::kFace) {
    return {dot(away_W, o.direction_W), o.direction_W, {}, 0};
  }
  const Vec3 flat_W = o.kind == FeatureKind::kEdge ? o.direction_W : Vec3{};
  const Vec3 across_W = away_W - dot(away_W, flat_W) * flat_W;
  const double distance = norm(across_W);
  if (!(distance > 0)) return {};
  return {distance, across_W / distance, flat_W, 1 / distance};
}

/// uᵀ ∇²d v
double bend_along(const View& view, const Vec3& u, const Vec3& v) {
  return view.bend * (dot(u, v) - dot(u, view.normal_W) * dot(v, view.normal_W) -
                      dot(u, view.flat_W) * dot(v, view.flat_W));
}

}  // namespace

SphereRest rest_in_crease(std::span<const RoundObstacle> obstacles, double distance,
                          const Vec3& from_W, const Vec3& tool_W) {
  const size_t m = obstacles.size();
  if (m < 2 || m > kMaxObstacles) return {};
  HAPTIC_ASSERT(distance > 0);
  constexpr std::array<Vec3, 3> kAxes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::array<View, kMaxObstacles> views;
  std::array<double, kMaxObstacles> push{};
  Vec3 x_W = from_W;
  // second derivative of ½|x − tool|² − Σ λ_i d_i
  const auto curvature = [&](const Vec3& u, const Vec3& v) {
    double sum = dot(u, v);
    for (size_t k = 0; k < m; ++k) sum -= push[k] * bend_along(views[k], u, v);
    return sum;
  };
  for (int step = 0; step < kMaxSteps; ++step) {
    const auto size = static_cast<Eigen::Index>(3 + m);
    Matrix a = Matrix::Zero(size, size);
    Vector b(size);
    for (size_t k = 0; k < m; ++k) views[k] = view_from(obstacles[k], x_W);
    for (int i = 0; i < 3; ++i) {
      b(i) = tool_W[i] - x_W[i];
      for (int j = 0; j < 3; ++j) {
        a(i, j) = curvature(kAxes[static_cast<size_t>(i)], kAxes[static_cast<size_t>(j)]);
      }
    }
    for (size_t k = 0; k < m; ++k) {
      const auto row = static_cast<Eigen::Index>(3 + k);
      b(row) = distance - views[k].distance;
      for (int i = 0; i < 3; ++i) {
        a(row, i) = views[k].normal_W[i];
        a(i, row) = -views[k].normal_W[i];
      }
    }
    const Vector y = a.partialPivLu().solve(b);
    const Vec3 way_W{y(0), y(1), y(2)};
    // rejects NaN, from dependent normals
    if (!(norm(way_W) <= kFarStep * distance)) return {};
    x_W += way_W;
    for (size_t k = 0; k < m; ++k) push[k] = y(static_cast<Eigen::Index>(3 + k));
    if (norm(way_W) > kSolved * distance) continue;
    for (size_t k = 0; k < m; ++k) {
      if (!(push[k] > 0)) return {};
    }
    const Vec3 along_W = cross(views[0].normal_W, views[1].normal_W);
    return {m > 2 || curvature(along_W, along_W) > 0, x_W};
  }
  return {};
}

}  // namespace haptic
