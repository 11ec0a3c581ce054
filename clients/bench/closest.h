// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/report/report.h"

namespace haptic {

struct BenchClosestOptions {
  int rounds = 3;
  std::string meshes;  // folder with armadillo.off; skipped if empty
};

/// Cost of the closest point on a mesh, with and without warm start, compared with Embree's point
/// query and CGAL's AABB tree. Workload W2: points dragged within 1 mm of the surface, and random
/// ones up to 20 mm outside. Errors are against brute force on a sample, and on all points between
/// the answers with and without warm start.
std::vector<Row> bench_closest(const BenchClosestOptions& options);

}  // namespace haptic
