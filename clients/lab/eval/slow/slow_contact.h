// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/lab/eval/scenes/free_scenes.h"
#include "clients/report/report.h"

namespace haptic {

/// All renderers of a body: another is one line.
const std::vector<JudgedRenderer>& slow_renderers();

/// A tool on an object, and the hand that leads it.
struct SlowScene {
  FreeScene scene;
  FreeHand hand = {};
  uint64_t first = 0, ticks = 0;  // of the ticks that are judged, and all
  double leaves = 0;              // x from which on the tool touches nothing [m]
};

/// A ball of 8 mm pressed half a millimetre into a ball of 50 mm and slid over it at 0.1 m/s;
/// `fineness` subdivides both. Voxels of 1 mm, surfaces where they are.
SlowScene ball_over_ball(uint32_t fineness);

/// A tool slid off a block at 0.5 m/s, at x = 20 mm: a box, or else a ball.
SlowScene off_an_edge(bool with_box);

/// The force of a session in each tick. The answer of a contact step is used from the tick after it
/// until the next one.
struct SlowRun {
  std::vector<Vec3> force_W;  // of the coupling
  std::vector<bool> is_felt;  // a force or torque; of renderers with mass, a contact that pushes
  std::vector<double> x;      // of the tool in the hand; of renderers with mass, of the proxy [m]
};
SlowRun run_slowly(const SlowScene& scene, const JudgedRenderer& renderer, uint32_t period,
                   uint32_t late = 0);

/// The difference of a session with slow contact from one whose contact steps in every tick.
struct Slowness {
  double error = 0;  // of the force, root mean square [N]
  double rough = 0;  // force above 50 Hz, root mean square [N]
  double mean = 0;   // force of the slow session [N]
  double most = 0;
};
Slowness compare_runs(const SlowScene& scene, const SlowRun& fresh, const SlowRun& slow);

/// The ticks in which something is felt more than a millimetre (two ticks of the hand) beyond the
/// place where the tool leaves the block.
uint64_t ghost_ticks(const SlowScene& scene, const SlowRun& run);

struct SlowEval {
  uint32_t fineness = 5;  // of the balls
  uint32_t phases = 20;   // of contact against the hand, at the edge
};

/// `hapt eval slow-contact`: contacts throttled to 50, 100, 200 and 1000 Hz.
void eval_slow_contact(const SlowEval& eval, const Rows& all);

}  // namespace haptic
