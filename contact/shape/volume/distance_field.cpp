// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/volume/distance_field.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr size_t kPieceOfBricks = 64;  // below, a thread does not pay off

using Place = std::array<int32_t, 3>;

size_t number_of(const Place& i, const std::array<int32_t, 3>& bricks) {
  return (static_cast<size_t>(i[2]) * static_cast<size_t>(bricks[1]) + static_cast<size_t>(i[1])) *
             static_cast<size_t>(bricks[0]) +
         static_cast<size_t>(i[0]);
}

Place place_of(size_t number, const std::array<int32_t, 3>& bricks) {
  const auto x = static_cast<size_t>(bricks[0]), y = static_cast<size_t>(bricks[1]);
  return {static_cast<int32_t>(number % x), static_cast<int32_t>(number / x % y),
          static_cast<int32_t>(number / (x * y))};
}

Vec3 corner_of(const DistanceFieldData& field, const Place& i) {
  return field.lower_O + (kFieldSide * field.cell) * Vec3{1.0 * i[0], 1.0 * i[1], 1.0 * i[2]};
}

/// Half the diagonal of a brick [m].
double reach_of(double cell) {
  return 0.5 * std::sqrt(3.0) * kFieldSide * cell;
}

/// Calls f for each of n pieces, split over two threads.
void for_halves(size_t first, size_t n, const RunBoth& run_both,
                const std::function<void(size_t)>& f) {
  if (!run_both || n <= kPieceOfBricks) {
    for (size_t i = first; i < first + n; ++i) f(i);
    return;
  }
  const auto run = [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) f(i);
  };
  run_both([&] { run(first, first + n / 2); }, [&] { run(first + n / 2, first + n); });
}

void fill_brick(const DistanceFieldData& field, const Place& place, const SignedDistance& distance,
                FieldBrick& brick) {
  // indices count from the corner of the field: the borders of neighbouring bricks are
  // bit-identical
  for (int z = 0; z < kFieldNodes; ++z) {
    for (int y = 0; y < kFieldNodes; ++y) {
      for (int x = 0; x < kFieldNodes; ++x) {
        const Vec3 node{1.0 * (kFieldSide * place[0] + x), 1.0 * (kFieldSide * place[1] + y),
                        1.0 * (kFieldSide * place[2] + z)};
        const double phi = distance(field.lower_O + field.cell * node);
        const double share = std::clamp(phi / field.band, -1.0, 1.0);
        brick.nodes[static_cast<size_t>((z * kFieldNodes + y) * kFieldNodes + x)] =
            static_cast<int16_t>(std::lround(share * kFieldUnits));
      }
    }
  }
}

/// A cell, and the place within it.
struct InCell {
  const int16_t* nodes = nullptr;  // at its lower corner; null: only a bound is known
  double x = 0, y = 0, z = 0;      // [cells]
  double bound = 0;                // [m]
};

constexpr int kY = kFieldNodes, kZ = kFieldNodes * kFieldNodes;

double bound_beyond(const DistanceField& field, const Vec3& q) {
  // the surface is at least a band inside the border
  Vec3 beyond;
  for (int k = 0; k < 3; ++k) {
    const double last = field.bricks[static_cast<size_t>(k)] * kFieldSide;
    const double cells = std::max({0.0, -q[k], q[k] - last});
    beyond[k] = cells > 0 ? field.cell * cells + field.band : 0;
  }
  // not-a-number counts as far
  return std::max(norm(beyond), field.band);
}

/// Bound from the exact distance at the middle of the brick; bricks without data are beyond the
/// band.
double bound_far(const DistanceField& field, size_t number, const Place& place, const Vec3& q) {
  const Vec3 middle = kFieldSide * Vec3{place[0] + 0.5, place[1] + 0.5, place[2] + 0.5};
  const auto at_middle = static_cast<double>(field.middle[number]);
  const double least = std::max(std::fabs(at_middle) - field.cell * norm(q - middle), field.band);
  return std::copysign(least, at_middle);
}

InCell field_cell_at(const DistanceField& field, const Vec3& p_O) {
  const Vec3 q = (1 / field.cell) * (p_O - field.lower_O);
  const double last_x = field.bricks[0] * kFieldSide, last_y = field.bricks[1] * kFieldSide,
               last_z = field.bricks[2] * kFieldSide;
  const bool is_inside =
      q.x >= 0 && q.x <= last_x && q.y >= 0 && q.y <= last_y && q.z >= 0 && q.z <= last_z;
  if (!is_inside) return {nullptr, 0, 0, 0, bound_beyond(field, q)};
  const auto x = static_cast<int32_t>(std::min(q.x, last_x - 1)),
             y = static_cast<int32_t>(std::min(q.y, last_y - 1)),
             z = static_cast<int32_t>(std::min(q.z, last_z - 1));
  const Place place{x / kFieldSide, y / kFieldSide, z / kFieldSide};
  const size_t number = number_of(place, field.bricks);
  const uint32_t brick = field.index[number];
  if (brick == kNoFieldBrick) return {nullptr, 0, 0, 0, bound_far(field, number, place, q)};
  const int32_t node = (z % kFieldSide) * kZ + (y % kFieldSide) * kY + x % kFieldSide;
  return {&field.data[brick].nodes[static_cast<size_t>(node)], q.x - x, q.y - y, q.z - z, 0};
}

/// Interpolation along x from the corner `at` of the cell, in units of the band.
double along(const InCell& c, int at) {
  return c.nodes[at] + c.x * (c.nodes[at + 1] - c.nodes[at]);
}
double slope(const InCell& c, int at) {
  return static_cast<double>(c.nodes[at + 1] - c.nodes[at]);
}

}  // namespace

FieldDistance sample_distance(const DistanceField& field, const Vec3& p_O) {
  const InCell c = field_cell_at(field, p_O);
  if (c.nodes == nullptr) return {c.bound, false};
  const double a00 = along(c, 0), a10 = along(c, kY), a01 = along(c, kZ), a11 = along(c, kY + kZ);
  const double b0 = a00 + c.y * (a10 - a00), b1 = a01 + c.y * (a11 - a01);
  return {field.band / kFieldUnits * (b0 + c.z * (b1 - b0)), true};
}

FieldSample sample_field(const DistanceField& field, const Vec3& p_O) {
  const InCell c = field_cell_at(field, p_O);
  if (c.nodes == nullptr) return {c.bound, {}, false};
  const double a00 = along(c, 0), a10 = along(c, kY), a01 = along(c, kZ), a11 = along(c, kY + kZ);
  const double b0 = a00 + c.y * (a10 - a00), b1 = a01 + c.y * (a11 - a01);
  const double s0 = slope(c, 0) + c.y * (slope(c, kY) - slope(c, 0)),
               s1 = slope(c, kZ) + c.y * (slope(c, kY + kZ) - slope(c, kZ));
  const double unit = field.band / kFieldUnits;
  const Vec3 gradient{s0 + c.z * (s1 - s0), (a10 - a00) + c.z * ((a11 - a01) - (a10 - a00)),
                      b1 - b0};
  return {unit * (b0 + c.z * (b1 - b0)), (unit / field.cell) * gradient, true};
}

DistanceFieldData build_distance_field(const Vec3& lower_O, const Vec3& upper_O,
                                       const SignedDistance& distance,
                                       const DistanceFieldOptions& options, const RunBoth& run_both,
                                       const std::function<void(double)>& progress) {
  DistanceFieldData field;
  HAPTIC_ASSERT(options.cell > 0 && options.band > 0);
  field.cell = options.cell;
  field.band = options.band;
  const double margin = std::max(options.margin, options.band);
  field.lower_O = lower_O - margin * Vec3{1, 1, 1};
  const double brick = kFieldSide * options.cell;
  for (size_t k = 0; k < 3; ++k) {
    const int axis = static_cast<int>(k);
    const double side = upper_O[axis] - lower_O[axis] + 2 * margin;
    field.bricks[k] = std::max(static_cast<int32_t>(std::ceil(side / brick)), 1);
  }
  const size_t places = static_cast<size_t>(field.bricks[0]) *
                        static_cast<size_t>(field.bricks[1]) * static_cast<size_t>(field.bricks[2]);
  field.middle.resize(places);
  for_halves(0, places, run_both, [&](size_t i) {
    const Vec3 half = 0.5 * brick * Vec3{1, 1, 1};
    field.middle[i] =
        static_cast<float>(distance(corner_of(field, place_of(i, field.bricks)) + half));
  });
  field.index.assign(places, kNoFieldBrick);
  std::vector<size_t> near;
  for (size_t i = 0; i < places; ++i) {
    const double least = std::fabs(static_cast<double>(field.middle[i])) - reach_of(options.cell);
    if (least > options.band) continue;
    field.index[i] = static_cast<uint32_t>(near.size());
    near.push_back(i);
  }
  field.data.resize(near.size());
  constexpr size_t kReports = 50;
  const size_t piece = std::max(near.size() / kReports, kPieceOfBricks + 1);
  for (size_t first = 0; first < near.size(); first += piece) {
    for_halves(first, std::min(piece, near.size() - first), run_both, [&](size_t i) {
      fill_brick(field, place_of(near[i], field.bricks), distance, field.data[i]);
    });
    if (progress) {
      progress(static_cast<double>(std::min(first + piece, near.size())) /
               static_cast<double>(near.size()));
    }
  }
  return field;
}

}  // namespace haptic
