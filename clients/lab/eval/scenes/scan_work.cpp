// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/scenes/scan_work.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "contact/query/point/segment_hit.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr double kWayPerTick = 0.13e-3;  // top speed of the slides, 0.13 m/s [m]

}  // namespace

void add_scan_size(Command& command, double& size) {
  command
      .quantity("--size", size, Dimension::kLength, {1e-3, 10},
                "longest side of a mesh file; a number without unit is in metres", "m")
      .show_default();
}

ToolPath path_through(std::vector<Vec3> positions) {
  const auto way = std::make_shared<const std::vector<Vec3>>(std::move(positions));
  return [way](double t) {
    const size_t last = way->size() - 1;
    const double at = std::clamp(t / kTick, 0.0, static_cast<double>(last));
    const auto k = std::min(static_cast<size_t>(at), last);
    const double part = at - static_cast<double>(k);
    return (*way)[k] + part * ((*way)[std::min(k + 1, last)] - (*way)[k]);
  };
}

ToolPath way_around(const MeshShape& shape, double tool_radius, uint64_t ticks) {
  const Vec3 middle = 0.5 * (shape.mesh.lower + shape.mesh.upper);
  const double far = norm(shape.mesh.upper - shape.mesh.lower);
  std::vector<Vec3> way;
  double radius = 0.5 * far;
  double t = 0;
  for (uint64_t k = 0; k < ticks + 2; ++k) {
    const Vec3 u = sphere_direction(t);
    const SegmentHit hit = first_hit(shape, middle + far * u, middle);
    if (hit.hit) radius = (1 - hit.t) * far;
    const Vec3 wanted =
        middle + (radius + tool_radius - workload_depth(kTick * static_cast<double>(k))) * u;
    const Vec3 step = way.empty() ? Vec3{} : wanted - way.back();
    const double length = norm(step);
    const double share = length > kWayPerTick ? kWayPerTick / length : 1;
    way.push_back(way.empty() ? wanted : way.back() + share * step);
    // at a jump of the surface the path waits until the tool has caught up
    if (length < 10 * kWayPerTick) t += kTick;
  }
  return path_through(std::move(way));
}

}  // namespace haptic
