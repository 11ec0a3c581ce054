// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <string_view>
#include <vector>

#include "clients/report/report.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/math/pose.h"

namespace haptic {

/// Scenes in which symmetry determines the answer of a 6-DoF renderer, after Weller, Mainzer,
/// Sagardia, Hulin, Zachmann & Preusche 2010.
enum class QualityScene {
  kConeOnPlane,          // a blunt cone slides along a block at constant depth
  kSphereRoundCylinder,  // a sphere moves once around a cylinder without rotating
  kCubeOnPlate,          // a cube turns about the vertical, flat and tilted
  kPegInHole             // a peg is moved aside, tilted and pushed in
};
std::string_view name_of(QualityScene scene);

/// Resolution of a scene.
struct QualityGrain {
  size_t samples = 120;     // poses per path
  uint32_t fineness = 4;    // of the round meshes: 64 steps around for each
  double voxel = 0.5e-3;    // edge of a voxel and a cell of the field [m]
  double spacing = 0.4e-3;  // between points of the tool; see spacing_of() [m]
};
/// A quarter of grain.spacing for the sphere, which touches with the fewest points.
double spacing_of(QualityScene scene, const QualityGrain& grain);

/// Both bodies; O coincides with W.
struct QualityBodies {
  Soup object, tool;
};
QualityBodies bodies_of(QualityScene scene, const QualityGrain& grain);

/// The wrench on the hand with the tool at rest at X_WT, about the tool's origin, in W.
using WrenchAt = std::function<Wrench(const Pose& X_WT)>;

/// Half the edge of the cube, radius of the sphere, half the length of the peg, and the clearance
/// between its radius and the hole's [m].
inline constexpr double kCubeHalf = 10e-3, kSphereRadius = 10e-3, kPegHalf = 20e-3;
inline constexpr double kPegClearance = 0.2e-3;
inline constexpr double kQualityDepth = 0.5e-3;  // of cone, sphere and cube in the object [m]

/// Goals of the scenes; dimensionless unless a unit is given.
struct QualityGoals {
  bool are_judged = true;         // false: figures without goals
  double cone_spread = 0.01;      // std/mean of |F|
  double cone_direction = 1;      // [deg]
  double cone_tangential = 0.02;  // relative to the normal force
  double sphere_spread = 0.03;    // peak-to-peak |F| relative to its mean
  double sphere_direction = 2;    // rms [deg]
  double sphere_torque = 0.01;    // relative to |F| R
  double cube_torque = 0.01;      // about x and y, flat; relative to |F| times half the edge
  double cube_mirror = 1e-3;      // difference of mirrored torques, relative to the largest
  double peg_fit = 0.99;          // R² of F over e − c, at least
};

/// Leads the tool through a scene and reports the deviations from symmetry. Noise is the RMS of F
/// minus its moving average over 21 samples, relative to mean |F|, with F in a frame that turns
/// with the ideal force.
void judge_quality(QualityScene scene, const WrenchAt& wrench_at, size_t samples,
                   const QualityGoals& goals, const std::string& case_name, const Rows& all);

}  // namespace haptic
