// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

class Command;

/// `hapt bench segment`: the first hit of a dragged probe (workload W1), beside other libraries in
/// alternation, and hybrid : grid : tree : naive.
void add_bench_segment(Command& bench);

}  // namespace haptic
