// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/report/report.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The two scenes in which the penalty method shows its artefacts, and the coupling forces felt
/// there with contact in every tick, answered within it.
enum class ArtefactScene {
  kEdge,  // along x at 2 mm/s below the edge of a block, 2 mm under both its faces at the middle
  kPlate  // at 40 mm/s down through a plate of 4 mm, to 6 mm behind the face it came in by
};

/// What is known of a scene in closed form.
inline constexpr double kEdgeStiffness = 1000, kEdgeDepth = 2e-3;   // [N/m], [m]
inline constexpr double kPlateStiffness = 400, kPlateWidth = 4e-3;  // [N/m], [m]
inline constexpr double kPlateEnd = 6e-3;                           // behind the first face [m]

/// Tool and force, tick by tick, once the hand has taken its place.
struct ArtefactRun {
  std::vector<double> t;  // [s]
  std::vector<Vec3> tool_W, force_W;

  double largest_step() const;                         // of the force in one tick [N]
  double largest_step_beyond(double stiffness) const;  // beyond stiffness times the tool's way [N]
  double most_resisting() const;                       // largest force against the way, +z [N]
  double most_helping() const;  // largest force along it, −z, as a positive number [N]
};
ArtefactRun run_artefact(ArtefactScene scene, Renderer renderer);

/// The whole of `hapt eval --protocol artefacts`: the force of each renderer in both scenes beside
/// what theory says. Goals: penalty3 turns its force by √2·k·d at once where the nearest face
/// changes, resists a plate of width w by at most k·w/2 and then helps the tool through by as much;
/// the proxies do neither. `plot`: an .svg, or empty.
std::vector<Row> eval_artefacts(const std::string& plot);

}  // namespace haptic
