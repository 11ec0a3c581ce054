// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench proximity`: all pairs of triangles within 0.1 mm, from scratch and with a
/// bounding-volume-tree front kept from pose to pose, and their reduction to contacts, compared
/// with FCL's collision and distance (W3); conservative advancement, also on FCL's distance (W5b).
void add_bench_proximity(Command& bench);

}  // namespace haptic
