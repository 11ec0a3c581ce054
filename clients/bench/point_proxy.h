// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/eval/scenes/workload.h"
#include "clients/report/report.h"

namespace haptic {

struct BenchPointProxyOptions {
  std::vector<std::string> meshes{"hf:50",     "hf:187",    "hf:374",     "hf:742",
                                  "sphere:16", "sphere:59", "sphere:118", "sphere:235"};
  std::vector<double> radii{0, 1e-3, 5e-3};  // of the proxy; the path keeps its depth [m]
  int repetitions = 5;                       // of the same path; the fastest of each tick counts
  int ticks = kEvalTicks;
};

/// Cost of a whole contact step of virtual-proxy3 on the benchmark set: CPU time of the thread
/// (CLOCK_THREAD_CPUTIME_ID minus the cost of reading it) of each tick, the least of the
/// repetitions, which excludes disturbances by the machine. One further pass reports what rt_guard
/// catches and how many contacts there are.
std::vector<Row> bench_point_proxy(const BenchPointProxyOptions& options);

}  // namespace haptic
