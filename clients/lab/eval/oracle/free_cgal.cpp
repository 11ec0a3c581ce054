// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/oracle/free_cgal.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>

#include "clients/lab/support/triangles_cgal.h"

namespace haptic {
namespace {

constexpr double kKept = 0.9;  // the bound is at least this fraction of the distance

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

}  // namespace

struct FreeOracle::Object : CgalTriangles<Kernel> {
  explicit Object(const Soup& soup) : CgalTriangles(soup.vertices, soup.triangles) {
    tree.accelerate_distance_queries();
  }
  double distance(const Vec3& p) const {
    return std::sqrt(tree.squared_distance(Kernel::Point_3(p.x, p.y, p.z)));
  }
};

FreeOracle::Patch FreeOracle::patch_of(const std::array<Vec3, 3>& corners) {
  Patch patch{corners, (corners[0] + corners[1] + corners[2]) / 3, 0};
  for (const Vec3& p : corners) patch.radius = std::max(patch.radius, norm(p - patch.centre));
  return patch;
}

FreeOracle::FreeOracle(const Soup& object, const Soup& tool)
    : object_(std::make_unique<Object>(object)) {
  for (const Triangle& t : tool.triangles) {
    patches_.push_back(patch_of({tool.vertices[t[0]], tool.vertices[t[1]], tool.vertices[t[2]]}));
  }
  if (patches_.empty()) patches_.push_back({});
  for (const Patch& patch : patches_) centre_T_ += patch.centre;
  centre_T_ = centre_T_ / static_cast<double>(patches_.size());
  for (const Patch& patch : patches_) {
    radius_ = std::max(radius_, norm(patch.centre - centre_T_) + patch.radius);
  }
}

FreeOracle::~FreeOracle() = default;
FreeOracle::FreeOracle(FreeOracle&&) noexcept = default;

/// Lowers `nearest` to the distance of the patch, to within a tenth: parts whose ball cannot lower
/// it by more are pruned, others are split in four.
void FreeOracle::search(const Patch& patch_T, Search& search) const {
  if (search.nearest < search.least) return;
  const double here = object_->distance(search.X_OT * patch_T.centre);
  search.nearest = std::min(search.nearest, here);
  if (here - patch_T.radius >= kKept * search.nearest) return;
  const auto& [a, b, c] = patch_T.corners;
  const Vec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
  for (const auto& part : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) {
    this->search(patch_of(part), search);
  }
}

double FreeOracle::at_least(const Pose& X_OT, double least, double enough) const {
  const double middle = object_->distance(X_OT * centre_T_);
  if (middle - radius_ >= enough) return enough;
  Search search{X_OT, least, enough / kKept};
  for (const Patch& patch : patches_) {
    // the tool's centre bounds the distance of every patch
    if (middle - norm(patch.centre - centre_T_) - patch.radius >= search.nearest) continue;
    this->search(patch, search);
  }
  return search.nearest < least ? 0 : kKept * search.nearest;
}

}  // namespace haptic
