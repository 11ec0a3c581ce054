// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "proto/wire/proxy_solver.h"

namespace haptic {

/// A row of proto/wire/renderers.def; few need to know them (proto/wire/renderer.h).
enum class Renderer : uint32_t;

inline constexpr double kBandVoxels = 2;  // default band of a field beyond the force layer [voxels]

/// How the proxy of a 6-DoF tool moves.
struct ProxyConfig {
  // none: the renderer's own; direct for direct6, quasi-static for voxel
  std::optional<SoftSolver> solver;
  Integrator integrator = Integrator::kImplicit;  // of penalty dynamics
  double contact_stiffness = 1000;  // of contacts that give none: those of direct6 [N/m]
  double contact_damping = 0;       // of each contact along its normal [N·s/m]
};

/// The two readings of the braking force of McNeely, Puterbaugh, Troy 1999.
enum class Braking : uint32_t {
  kAlongVelocity = 0,  // −b v (−n̂·v̂), the paper's
  kAlongNormal = 1     // −b (v·n̂) n̂, a later review's
};

/// Maps, field and points of the detector `voxel`.
struct VoxelConfig {
  double size = 1e-3;           // edge of a voxel and of a cell of the field [m]
  double band = 4e-3;           // distance from the surface within which the field is exact [m]
  double point_spacing = 1e-3;  // of the tool's points [m]
  double stiffness = 1000;      // per point [N/m]
  double braking = 0;           // of approaching points [N·s/m]
  Braking braking_along = Braking::kAlongVelocity;
  uint32_t offset_layers = 2;  // distance of the felt surface outside the real one [voxels]
  uint32_t field = 1;          // 1: a distance field is baked; 0: the voxel map alone
  uint32_t open_as_sheet = 0;  // 1: an open mesh becomes a sheet one voxel thick
  uint32_t budget = 30000;     // points looked up per step; 0: unlimited
  uint32_t is_wanted = 0;      // 1: the section is present: baked even if another renderer starts
};

/// The verified pose of the renderers god-object6 and constrained6.
struct RigidConfig {
  double k_s = 2;      // of the paper: a move covers k_s/2 of the remaining way
  double margin = 0;   // to every surface [m]; 0: 1e-4 of the tool's radius
  uint32_t moves = 8;  // per step of contact, at most
  RigidSolver solver = RigidSolver::kCoulomb;  // of constrained6
};

/// Default band of a field [m]: the force layer and two voxels beyond it.
inline double default_band(const VoxelConfig& voxel) {
  return (voxel.offset_layers + kBandVoxels) * voxel.size;
}

}  // namespace haptic
