// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench segment`: first hit of a dragged probe (workload W1), in alternation with other
/// libraries, and the ratios hybrid : grid : tree : naive.
void add_bench_segment(Command& bench);

}  // namespace haptic
