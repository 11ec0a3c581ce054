// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/report/report.h"

namespace haptic {

/// CPU time of sim's steps in a scene where bodies move, over the first 10 s of its hand, in
/// lockstep, so that nothing but they is timed; and where all are at rest, without a hand. How many
/// ticks sim would leave out by its rests, with a processor of its own, and how many more behind a
/// stall of 8 ms after 1.5 s. Throws ConfigError and MeshError.
void add_scene_steps(const std::string& file, const Rows& all);

}  // namespace haptic
