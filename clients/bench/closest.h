// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/report/report.h"

namespace haptic {

struct BenchClosestOptions {
  int rounds = 3;
  std::string meshes;  // folder with armadillo.off; empty: left out
};

/// What the closest point of a mesh costs, with a witness and without, beside Embree's point query
/// and CGAL's AABB tree: workload W2, points dragged within 1 mm of the surface and random ones up
/// to 20 mm outside. Errors are those against brute force on a sample, and between the answers with
/// and without a witness on all.
std::vector<Row> bench_closest(const BenchClosestOptions& options);

}  // namespace haptic
