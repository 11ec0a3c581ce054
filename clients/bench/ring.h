// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "clients/report/report.h"

namespace haptic {

struct BenchRingOptions {
  int rounds = 5;
};

/// What the ring costs between two processes, each on a processor of its own at SCHED_FIFO where
/// that is granted; what was refused is a row.
///
/// One way: from before the writer's copy to after the reader's, one message under way at a time,
/// so that no backlog is measured. Throughput: with credit, so that nothing is lost; the queue
/// blocks instead. Publish: of a whole ServoFrame into the segment the servo uses. Ring and queue
/// take turns in each round; a figure is the median over the rounds.
std::vector<Row> bench_ring(const BenchRingOptions& options);

}  // namespace haptic
