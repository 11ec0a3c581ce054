// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/shell_pushes.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

const double kHalfDiagonal = 0.5 * std::sqrt(3.0);  // half the diagonal of a voxel, in edges

Vec3 point_T(const Pointshell& shell, uint32_t i) {
  return {static_cast<double>(shell.x[i]), static_cast<double>(shell.y[i]),
          static_cast<double>(shell.z[i])};
}
Vec3 normal_T(const Pointshell& shell, uint32_t i) {
  return {static_cast<double>(shell.nx[i]), static_cast<double>(shell.ny[i]),
          static_cast<double>(shell.nz[i])};
}

/// Scales the pushes by the shared stiffness: those that touch share among themselves; those that
/// approach as if they touched, too, or they would be far stiffer.
void share(std::span<PointPush> pushes, const ShellForce& force) {
  double touching = 0, near = 0;
  for (const PointPush& push : pushes) (push.depth > 0 ? touching : near) += push.count;
  const double of_touching = shared_stiffness(force, touching);
  const double of_near = shared_stiffness(force, touching + near);
  for (PointPush& push : pushes) push.stiffness *= push.depth > 0 ? of_touching : of_near;
}

}  // namespace

double shared_stiffness(const ShellForce& force, double n_touching) {
  HAPTIC_ASSERT(force.sharing > 0);
  return n_touching >= force.sharing ? force.stiffness * force.sharing / n_touching
                                     : force.stiffness;
}

double deepest_in_voxel(const Voxmap& map) {
  return kHalfDiagonal * map.size;
}

size_t pushes_from_voxels(const Voxmap& map, const Pointshell& shell, const Pose& X_OT,
                          std::span<const VoxelHit> hits, const ShellForce& force,
                          std::span<PointPush> pushes) {
  HAPTIC_ASSERT(map.size > 0 && is_unit(X_OT.q));
  const double deepest = deepest_in_voxel(map);
  size_t n = 0;
  for (const VoxelHit& hit : hits) {
    if (n == pushes.size()) break;
    PointPush& push = pushes[n];
    HAPTIC_ASSERT(hit.point() < shell.x.size());
    push.point_O = X_OT * point_T(shell, hit.point());
    push.normal_O = rotate(X_OT.q, normal_T(shell, hit.point()));
    push.stiffness = push.count = 1;
    push.depth = hit.voxel() == Voxel::kInterior ? deepest : -deepest;
    if (hit.voxel() == Voxel::kSurface) {
      const Vec3 middle_O = map.centre_of(map.index_of(push.point_O));
      push.depth = dot(middle_O - push.point_O, push.normal_O);
    }
    ++n;
  }
  share(pushes.first(n), force);
  return n;
}

size_t pushes_from_field(const Pointshell& shell, const Pose& X_OT,
                         std::span<const ShellTouch> touches, const ShellForce& force,
                         std::span<PointPush> pushes) {
  HAPTIC_ASSERT(is_unit(X_OT.q));
  const Mat3 R_OT = to_matrix(X_OT.q);
  const size_t n = std::min(touches.size(), pushes.size());
  for (size_t i = 0; i < n; ++i) {
    const ShellTouch& touch = touches[i];
    HAPTIC_ASSERT(touch.point < shell.x.size());
    const double count = touch.count;
    pushes[i] = {X_OT.p + R_OT * point_T(shell, touch.point), R_OT * normal_T(shell, touch.point),
                 force.offset - touch.distance, count, count};
  }
  share(pushes.first(n), force);
  return n;
}

Mat6 braking_matrix(std::span<const PointPush> pushes, const Twist& V_OT, const Vec3& about_O,
                    double damping, Braking reading) {
  HAPTIC_ASSERT(damping >= 0);
  Mat6 B;
  for (const PointPush& push : pushes) {
    if (push.depth > 0) continue;
    const Vec3 arm = push.point_O - about_O;
    const Vec3 v = velocity_at(V_OT, arm);
    const double speed = norm(v), approach = -dot(push.normal_O, v);
    if (!(approach > 0)) continue;
    const double b = damping * push.count;
    const auto add_along = [&](const Vec3& u, double by) {
      const Vec3 turn = cross(arm, u);
      add_outer(B, {u, turn}, {-by * u, -by * turn});
    };
    if (reading == Braking::kAlongNormal) {
      add_along(push.normal_O, b);
      continue;
    }
    for (const Vec3& u : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      add_along(u, b * approach / speed);
    }
  }
  return B;
}

}  // namespace haptic
