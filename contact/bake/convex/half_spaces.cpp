// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/half_spaces.h"

namespace haptic {
namespace {

constexpr int kSteps = 60;       // a bound of the loop; most points need a few
constexpr double kBeyond = 1.2;  // of the way to the plane: below 2 it converges, above 1 it ends

}  // namespace

Vec3 into_half_spaces(Vec3 p, std::span<const Plane> planes, double tolerance) {
  for (int step = 0; step < kSteps; ++step) {
    const Plane* worst = nullptr;
    double most = tolerance;
    for (const Plane& plane : planes) {
      const double above = plane.above(p);
      if (above > most) worst = &plane, most = above;
    }
    if (worst == nullptr) return p;
    p -= kBeyond * most * worst->normal;
  }
  return p;
}

}  // namespace haptic
