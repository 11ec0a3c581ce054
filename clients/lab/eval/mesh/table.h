// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "clients/lab/eval/mesh/renderer.h"

namespace haptic {

/// Several evaluations: every mesh with every radius and every latency.
struct EvalTable {
  RendererEval each;                // common settings
  std::vector<std::string> meshes;  // "all": the benchmark set
  std::vector<double> radii;        // of the proxy [m]
  std::vector<uint32_t> latencies;  // [ticks]
};

/// The benchmark set: the plane, then each family from coarse to fine.
std::vector<std::string> published_work();

std::vector<RendererEval> cases_of(const EvalTable& table);

/// One line for people per case, below the names of the columns; rows as returned by eval_renderer,
/// case after case.
void print_cases(std::ostream& out, const std::vector<std::vector<Row>>& cases);

}  // namespace haptic
