// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "clients/report/report.h"

namespace haptic {

struct BenchRingOptions {
  int rounds = 5;
};

/// Cost of the ring between two processes, each on its own processor at SCHED_FIFO if granted;
/// refused rights are reported in a row.
///
/// One way: from before the writer's copy to after the reader's, one message at a time, so that no
/// backlog is measured. Throughput: with credit, so that nothing is lost; the queue blocks instead.
/// Publish: a whole ServoFrame into the servo's segment. Ring and queue alternate within each
/// round; a figure is the median over the rounds.
std::vector<Row> bench_ring(const BenchRingOptions& options);

}  // namespace haptic
