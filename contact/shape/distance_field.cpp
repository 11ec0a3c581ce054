// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/distance_field.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kUnits = 32767;       // of the band
constexpr size_t kPieceOfBricks = 64;  // below, a thread is not worth its start

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

/// Half the diagonal of a brick.
double reach_of(double cell) {
  return 0.5 * std::sqrt(3.0) * kFieldSide * cell;
}

/// f for each of n pieces, by halves on two threads.
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
  // a whole number of cells from the corner of the field: borders of two bricks agree to the bit
  for (int z = 0; z < kFieldNodes; ++z) {
    for (int y = 0; y < kFieldNodes; ++y) {
      for (int x = 0; x < kFieldNodes; ++x) {
        const Vec3 node{1.0 * (kFieldSide * place[0] + x), 1.0 * (kFieldSide * place[1] + y),
                        1.0 * (kFieldSide * place[2] + z)};
        const double phi = distance(field.lower_O + field.cell * node);
        const double share = std::clamp(phi / field.band, -1.0, 1.0);
        brick.nodes[static_cast<size_t>((z * kFieldNodes + y) * kFieldNodes + x)] =
            static_cast<int16_t>(std::lround(share * kUnits));
      }
    }
  }
}

}  // namespace

FieldSample sample_field(const DistanceField& field, const Vec3& p_O) {
  const Vec3 q = (p_O - field.lower_O) / field.cell;
  Place cell{}, place{};
  Vec3 beyond;
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<size_t>(k);
    const double last = field.bricks[axis] * kFieldSide;
    beyond[k] = std::max({-q[k], q[k] - last, 0.0});
    cell[axis] = static_cast<int32_t>(std::clamp(q[k], 0.0, last - 1));
    place[axis] = cell[axis] / kFieldSide;
  }
  FieldSample sample;
  const size_t number = number_of(place, field.bricks);
  if (norm_squared(beyond) > 0) {
    // the surface is at least a band within the border
    for (int k = 0; k < 3; ++k) beyond[k] = beyond[k] > 0 ? field.cell * beyond[k] + field.band : 0;
    sample.distance = norm(beyond);
    return sample;
  }
  const uint32_t brick = field.index[number];
  if (brick == kNoFieldBrick) {
    const auto middle = static_cast<double>(field.middle[number]);
    // what is not stored is beyond the band
    const double least = std::max(std::fabs(middle) - reach_of(field.cell), field.band);
    sample.distance = std::copysign(least, middle);
    return sample;
  }
  const auto local = [&](size_t axis) { return cell[axis] - place[axis] * kFieldSide; };
  const int16_t* n = &field.data[brick].nodes[static_cast<size_t>(
      (local(2) * kFieldNodes + local(1)) * kFieldNodes + local(0))];
  constexpr int kY = kFieldNodes, kZ = kFieldNodes * kFieldNodes;
  const double x = q.x - cell[0], y = q.y - cell[1], z = q.z - cell[2];
  const auto along = [&](int at) { return n[at] + x * (n[at + 1] - n[at]); };
  const auto slope = [&](int at) { return static_cast<double>(n[at + 1] - n[at]); };
  const double a00 = along(0), a10 = along(kY), a01 = along(kZ), a11 = along(kY + kZ);
  const double b0 = a00 + y * (a10 - a00), b1 = a01 + y * (a11 - a01);
  const double s0 = slope(0) + y * (slope(kY) - slope(0)),
               s1 = slope(kZ) + y * (slope(kY + kZ) - slope(kZ));
  const double unit = field.band / kUnits;
  sample.distance = unit * (b0 + z * (b1 - b0));
  sample.gradient_O =
      (unit / field.cell) *
      Vec3{s0 + z * (s1 - s0), (a10 - a00) + z * ((a11 - a01) - (a10 - a00)), b1 - b0};
  sample.is_near = true;
  return sample;
}

DistanceFieldData build_distance_field(const Vec3& lower_O, const Vec3& upper_O,
                                       const SignedDistance& distance,
                                       const DistanceFieldOptions& options, const RunBoth& run_both,
                                       const std::function<void(double)>& progress) {
  DistanceFieldData field;
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
