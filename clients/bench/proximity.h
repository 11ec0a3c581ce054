// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench proximity`: all pairs of triangles within 0.1 mm of each other, from scratch and
/// with a front remembered from pose to pose, and the contacts that stand for them, beside FCL's
/// collision and distance (W3); conservative advancement beside the same on FCL's distance (W5b).
void add_bench_proximity(Command& bench);

}  // namespace haptic
