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

/// Scenes in which symmetry says what a renderer with six degrees of freedom must answer, after
/// Weller, Mainzer, Sagardia, Hulin, Zachmann, Preusche 2010.
enum class QualityScene {
  kConeOnPlane,          // a blunt cone slid along a block at one depth
  kSphereRoundCylinder,  // a sphere led once round a cylinder, without turning itself
  kCubeOnPlate,          // a cube turned about the vertical, flat and tilted
  kPegInHole             // a peg moved aside, tilted and pushed in
};
std::string_view name_of(QualityScene scene);

/// How finely a scene is cut and walked.
struct QualityGrain {
  size_t samples = 120;     // of each way
  uint32_t fineness = 4;    // of the round meshes: 64 steps around for each
  double voxel = 0.5e-3;    // size of a voxel and a cell of the field [m]
  double spacing = 0.4e-3;  // of the tool's points; see spacing_of [m]
};
/// A quarter on the sphere, which touches with the fewest.
double spacing_of(QualityScene scene, const QualityGrain& grain);

/// Both bodies; the object lies in W as it is.
struct QualityBodies {
  Soup object, tool;
};
QualityBodies bodies_of(QualityScene scene, const QualityGrain& grain);

/// What the hand feels with the tool held at X_WT, at rest: about the tool's origin, in W.
using WrenchAt = std::function<Wrench(const Pose& X_WT)>;

/// Half the edge of the cube, radius of the sphere, half the length of the peg, and the clearance
/// between its radius and the hole's [m].
inline constexpr double kCubeHalf = 10e-3, kSphereRadius = 10e-3, kPegHalf = 20e-3;
inline constexpr double kPegClearance = 0.2e-3;
inline constexpr double kQualityDepth = 0.5e-3;  // of cone, sphere and cube in the object [m]

/// What a scene asks of a renderer, without unit unless said.
struct QualityGoals {
  bool are_judged = true;         // false: the figures alone
  double cone_spread = 0.01;      // std/mean of |F|
  double cone_direction = 1;      // [deg]
  double cone_tangential = 0.02;  // of the force along the normal
  double sphere_spread = 0.03;    // peak to peak over mean of |F|
  double sphere_direction = 2;    // rms [deg]
  double sphere_torque = 0.01;    // of |F| R
  double cube_torque = 0.01;      // about x and y, flat; of |F| times half the edge
  double cube_mirror = 1e-3;      // difference of mirrored torques, of the largest
  double peg_fit = 0.99;          // R² of F over e − c, at least
};

/// Leads the tool through a scene and says how far the answers are from what symmetry demands.
/// Noise is the RMS of F − its moving average over 21 samples, over mean |F|, F in a frame that
/// turns with the ideal force.
std::vector<Row> judge_quality(QualityScene scene, const WrenchAt& wrench_at, size_t samples,
                               const QualityGoals& goals, const std::string& case_name);

}  // namespace haptic
