// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/detect/body/cluster_pushes.h"
#include "contact/query/volume/shell_in_field.h"
#include "contact/query/volume/voxel_scan.h"
#include "proto/config/config.h"

namespace haptic {

/// What a point that touches does.
struct ShellForce {
  double stiffness = 1000;  // K_ff of a point [N/m]
  double sharing = 10;      // from so many points on they share what so many would give
  double offset = 0;        // by which a field's surface lies outside the real one [m]
};

/// K_ff, or from `sharing` points on K_ff · sharing/n: force and torque stop to grow with the
/// number of points (McNeely, Puterbaugh, Troy 1999: divided by N/10 where N ≥ 10).
double shared_stiffness(const ShellForce& force, double n_touching);

/// Tangent planes through the middles of surface voxels, with the *point's* inward normal n (not
/// the voxel's): depth d = (C − P)·n, force K_ff d n where d > 0. Points in interior voxels have no
/// plane of their own: they push with the most that a surface voxel can, √3/2 of its edge, and
/// proximity voxels approach with the same depth of the other sign (McNeely, Puterbaugh, Troy
/// 1999). In O; positions on the tool. Returns how many pushes there are.
size_t pushes_from_voxels(const Voxmap& map, const Pointshell& shell, const Pose& X_OT,
                          std::span<const VoxelHit> hits, const ShellForce& force,
                          std::span<PointPush> pushes);

/// The distance field's: force K_ff (offset − φ) n along the point's inward normal n where φ <
/// offset, not along the gradient: continuous, and without flips where the nearest surface changes
/// (Barbič & James 2008). Others approach. In O. A touch that stands for several has their
/// stiffness. The offset is the force layer of McNeely, Puterbaugh, Troy 1999: where it is at least
/// the depth that the coupling can press to and the distance between the points, the real surfaces
/// stay apart.
size_t pushes_from_field(const Pointshell& shell, const Pose& X_OT,
                         std::span<const ShellTouch> touches, const ShellForce& force,
                         std::span<PointPush> pushes);

/// Braking wrench of the approaching points (depth ≤ 0, moving against their inward normal) about
/// about_O; v is a point's velocity relative to the object.
/// by_twist: B with B·V_OT = that wrench, its shares (−n̂·v̂) held: symmetric, never positive.
Mat6 braking_matrix(std::span<const PointPush> pushes, const Twist& V_OT, const Vec3& about_O,
                    double damping, Braking reading);
Wrench braking_wrench(std::span<const PointPush> pushes, const Twist& V_OT, const Vec3& about_O,
                      double damping, Braking reading);

}  // namespace haptic
