// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/detect/body/cluster_pushes.h"
#include "contact/query/volume/shell_in_field.h"
#include "contact/query/volume/voxel_scan.h"
#include "proto/config/config.h"

namespace haptic {

/// Parameters of the force of a point that touches.
struct ShellForce {
  double stiffness = 1000;  // K_ff of a point [N/m]
  double sharing = 10;      // number of points from which on they share the stiffness of so many
  double offset = 0;        // of a field's surface outside the real one [m]
};

/// K_ff, or from `sharing` points on K_ff · sharing/n: force and torque stop growing with the
/// number of points (McNeely, Puterbaugh, Troy 1999: divided by N/10 where N ≥ 10).
double shared_stiffness(const ShellForce& force, double n_touching);

/// The most that a point in a surface voxel can be behind the plane through its middle [m].
double deepest_in_voxel(const Voxmap& map);

/// Tangent planes through the centres of surface voxels, with the *point's* inward normal n (not
/// the voxel's): depth d = (C − P)·n, force K_ff d n where d > 0. Points in interior voxels have no
/// plane: they push with the most that a surface voxel can, √3/2 of its edge; points in proximity
/// voxels approach with minus that depth (McNeely, Puterbaugh, Troy 1999). In O; at positions on
/// the tool. Returns the number of pushes.
size_t pushes_from_voxels(const Voxmap& map, const Pointshell& shell, const Pose& X_OT,
                          std::span<const VoxelHit> hits, const ShellForce& force,
                          std::span<PointPush> pushes);

/// From a distance field φ: force K_ff (offset − φ) n along the point's inward normal n where φ <
/// offset, not along the gradient: continuous, without jumps where the nearest surface changes
/// (Barbič & James 2008). Other points approach. In O. A touch that represents several points has
/// their stiffness. The offset is the force layer of McNeely, Puterbaugh, Troy 1999: if it is at
/// least the depth that the coupling can press to, and the distance between points, the real
/// surfaces stay apart.
size_t pushes_from_field(const Pointshell& shell, const Pose& X_OT,
                         std::span<const ShellTouch> touches, const ShellForce& force,
                         std::span<PointPush> pushes);

/// B with B·V_OT = the braking wrench about about_O of the approaching points (depth ≤ 0, moving
/// against their inward normal); v is a point's velocity relative to the object. Symmetric and
/// negative semidefinite, for constant shares (−n̂·v̂).
Mat6 braking_matrix(std::span<const PointPush> pushes, const Twist& V_OT, const Vec3& about_O,
                    double damping, Braking reading);

}  // namespace haptic
