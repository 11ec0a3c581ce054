// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "clients/eval/renderer.h"

namespace haptic {

/// Many judgements in one go: every mesh with every radius and every latency.
struct EvalTable {
  RendererEval each;                // what they have in common
  std::vector<std::string> meshes;  // "all": the published work
  std::vector<double> radii;        // of the proxy [m]
  std::vector<uint32_t> latencies;  // [ticks]
};

/// The published work, coarse to fine, and the plane.
std::vector<std::string> published_work();

/// All cases, mesh by mesh.
std::vector<RendererEval> cases_of(const EvalTable& table);

/// One line for people about each judged case, with the columns' names above; rows as eval_renderer
/// gives them, case after case.
void print_cases(std::ostream& out, const std::vector<std::vector<Row>>& cases);

}  // namespace haptic
