// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/lab/eval/scenes/workload.h"
#include "clients/lab/support/traj.h"
#include "clients/lockstep/lockstep.h"
#include "clients/report/report.h"

namespace haptic {

/// The protocol of Ruffaldi, Morris, Edmunds, Barbagli & Pai 2006: a probe has scanned a surface
/// (the out-trajectory, with forces); a device of stiffness k held by the same hand would have been
/// inside by f/k (the in-trajectory); a renderer led along it should reproduce the force.
inline constexpr double kRuffaldiStiffness = 500;  // k of in-trajectory and coupling [N/m]

/// A smooth surface with ground truth: a mesh, and a probe at 1 kHz that presses along the normal
/// with up to 2.1 N. Force is zero in the air.
struct RuffaldiWork {
  Soup soup;
  std::vector<TrajSample> probe;    // positions on the surface, exact forces
  std::vector<Vec3> in_trajectory;  // without noise
  double facet_error = 0;           // bound h²κ/8·k of the error due to the facets [N]
};

/// "plane", "sphere" (50 mm), "torus" (60 and 20 mm) or "bumpy" (3 mm high). Throws
/// std::runtime_error with one line for another name.
RuffaldiWork make_ruffaldi_work(const std::string& surface, size_t ticks);

/// The in-trajectory of a scan: the nearest surface point of each sample, moved inside along the
/// facet's normal by the normal force over k; in the air the sample itself.
std::vector<Vec3> in_trajectory_of(const std::vector<TrajSample>& probe, const MeshShape& shape);

/// Adds the error of a tracker: normal distribution, σ [m] along each axis, fixed seed.
void add_noise(std::vector<Vec3>& positions, double sigma);

/// Rendered forces F compared with those of the probe, F*, while the probe was in contact.
struct ForceComparison {
  size_t samples = 0;
  double mean_force = 0;                               // of the probe [N]
  double rms = 0, rms_normal = 0, rms_tangential = 0;  // of F − F* [N]
  double max = 0;                                      // [N]
  double direction_jump = 0;  // largest change of direction of F in a tick [rad]
  int lag = 0;                // ticks by which F lags
  double rms_aligned = 0;     // rms with that lag removed [N]
};
ForceComparison compare_forces(const std::vector<TrajSample>& probe,
                               const std::vector<Vec3>& rendered);

/// Coupling forces of god-object3 led along the trajectory in lockstep.
std::vector<Vec3> render_trajectory(const MeshShape& shape, const std::vector<Vec3>& trajectory,
                                    const LockstepOptions& lockstep);

struct RuffaldiEval {
  std::string surface = "plane";
  std::string traj, mesh;  // a scan and its mesh file instead of a surface
  double noise = 1e-5;     // [m]
  double size = 0.15;      // longest side of the mesh file [m]
  size_t ticks = 10'000;
  LockstepOptions lockstep;
};

/// `hapt eval ruffaldi`. Goal: rms error at most 0.5 % of the mean force on plane and
/// sphere.
void eval_ruffaldi(const RuffaldiEval& eval, const Rows& all);

}  // namespace haptic
