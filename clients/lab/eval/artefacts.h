// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/report/report.h"
#include "proto/wire/renderer.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The two scenes in which the penalty method shows its artefacts. Contact runs in every tick and
/// is answered within it; the forces are those of the coupling.
enum class ArtefactScene {
  kEdge,  // along x at 2 mm/s inside a block; half way, 2 mm below two of its faces
  kPlate  // down at 40 mm/s through a plate of 4 mm, to 6 mm behind the entry face
};

/// Parameters of the scenes; the expected forces follow from them in closed form.
inline constexpr double kEdgeStiffness = 1000, kEdgeDepth = 2e-3;   // [N/m], [m]
inline constexpr double kPlateStiffness = 400, kPlateWidth = 4e-3;  // [N/m], [m]
inline constexpr double kPlateEnd = 6e-3;  // final depth behind the entry face [m]

/// Tool and force in each tick after kSettled.
struct ArtefactRun {
  std::vector<double> t;  // [s]
  std::vector<Vec3> tool_W, force_W;

  /// Largest change of force in one tick beyond stiffness times tool motion [N].
  double largest_step(double stiffness = 0) const;
  /// Largest force along this direction [N].
  double most_along(const Vec3& direction) const;
};
ArtefactRun run_artefact(ArtefactScene scene, Renderer renderer);

/// `hapt eval artefacts`: the force of each renderer in both scenes compared with
/// theory. Goals: penalty3 changes its force by √2·k·d at once where the nearest face changes; it
/// resists a plate of width w by at most k·w/2 and then pushes the tool through by as much. The
/// proxies do neither. `plot`: an .svg, or empty.
void eval_artefacts(const std::string& plot, const Rows& all);

}  // namespace haptic
