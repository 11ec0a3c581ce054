// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/parts/machine_parts.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

/// Adds rings of vertices from the lower to the upper height; returns the index of the first.
uint32_t add_part_side(Soup& soup, const RadiusAt& radius, double z_lower, double z_upper,
                       const PartGrid& grid) {
  HAPTIC_ASSERT(grid.around >= 3 && grid.along >= 1 && z_lower < z_upper);
  const auto first = static_cast<uint32_t>(soup.vertices.size());
  for (uint32_t k = 0; k <= grid.along; ++k) {
    const double z = z_lower + (z_upper - z_lower) * k / grid.along;
    for (uint32_t i = 0; i < grid.around; ++i) {
      const double theta = 2 * kPi * i / grid.around;
      const double r = radius(theta, z);
      HAPTIC_ASSERT(r > 0);
      soup.vertices.push_back({r * std::cos(theta), r * std::sin(theta), z});
    }
  }
  return first;
}

void add_quad(Soup& soup, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  soup.triangles.push_back({a, b, c});
  soup.triangles.push_back({a, c, d});
}

/// The faces between the rings of a side, facing outwards or towards the axis.
void close_side(Soup& soup, uint32_t first, const PartGrid& grid, bool faces_out) {
  for (uint32_t k = 0; k < grid.along; ++k) {
    for (uint32_t i = 0; i < grid.around; ++i) {
      const uint32_t j = (i + 1) % grid.around, row = first + k * grid.around;
      const uint32_t a = row + i, b = row + j, c = b + grid.around, d = a + grid.around;
      if (faces_out) {
        add_quad(soup, a, b, c, d);
      } else {
        // the same diagonal as on an outer side: the triangles of two nested threads must
        // correspond
        add_quad(soup, a, d, c, b);
      }
    }
  }
}

double radius_of_square(double half, double theta) {
  return half / std::max(std::fabs(std::cos(theta)), std::fabs(std::sin(theta)));
}

double radius_of_hexagon(double across_flats, double theta) {
  const double sector = kPi / 3;
  const double off = theta - sector * std::round(theta / sector);
  return 0.5 * across_flats / std::cos(off);
}

/// Relative height of the thread, from 0 at its root to 1 at its crest: a rounded trapezoid, a sine
/// clipped at 0.7.
double thread_at(double pitch, double theta, double z) {
  HAPTIC_ASSERT(pitch > 0);
  constexpr double kCut = 0.7;
  const double wave = std::cos(2 * kPi * z / pitch - theta);
  return 0.5 * (1 + std::clamp(wave / kCut, -1.0, 1.0));
}

/// Involute function tan α − α.
double involute(double alpha) {
  return std::tan(alpha) - alpha;
}

/// Half the angle of a tooth at a radius, seen from the axis [rad].
double half_tooth(const primitive::Gear& gear, double r) {
  constexpr double kPressure = 20 * kPi / 180;
  const double pitch_radius = 0.5 * gear.module * gear.teeth;
  const double base = pitch_radius * std::cos(kPressure);
  const double at_pitch = kPi / (2 * gear.teeth) - 0.5 * gear.backlash / pitch_radius;
  const double alpha = r > base ? std::acos(base / r) : 0;
  return at_pitch + involute(kPressure) - involute(alpha);
}

/// Radius of a gear at an angle: root, tip, or on the flank by bisection.
double gear_radius(const primitive::Gear& gear, double theta) {
  HAPTIC_ASSERT(gear.teeth > 0 && gear.module > 0);
  const double pitch_radius = 0.5 * gear.module * gear.teeth;
  const double foot = pitch_radius - 1.25 * gear.module, tip = pitch_radius + gear.module;
  const double sector = 2 * kPi / gear.teeth;
  const double off = std::fabs(theta - sector * std::round(theta / sector));
  if (off <= half_tooth(gear, tip)) return tip;
  if (off >= half_tooth(gear, foot)) return foot;
  double low = foot, high = tip;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (half_tooth(gear, middle) > off ? low : high) = middle;
  }
  return low;
}

}  // namespace

Soup make_turned(const RadiusAt& outer, double z_lower, double z_upper, const PartGrid& grid) {
  Soup soup;
  const uint32_t first = add_part_side(soup, outer, z_lower, z_upper, grid);
  close_side(soup, first, grid, true);
  const auto lower = static_cast<uint32_t>(soup.vertices.size());
  soup.vertices.push_back({0, 0, z_lower});
  soup.vertices.push_back({0, 0, z_upper});
  const uint32_t top = first + grid.along * grid.around;
  for (uint32_t i = 0; i < grid.around; ++i) {
    const uint32_t j = (i + 1) % grid.around;
    soup.triangles.push_back({lower, first + j, first + i});
    soup.triangles.push_back({lower + 1, top + i, top + j});
  }
  return soup;
}

Soup make_bored(const RadiusAt& outer, const RadiusAt& inner, double z_lower, double z_upper,
                const PartGrid& grid) {
  Soup soup;
  const uint32_t out = add_part_side(soup, outer, z_lower, z_upper, grid);
  const uint32_t in = add_part_side(soup, inner, z_lower, z_upper, grid);
  close_side(soup, out, grid, true);
  close_side(soup, in, grid, false);
  const uint32_t top = grid.along * grid.around;
  for (uint32_t i = 0; i < grid.around; ++i) {
    const uint32_t j = (i + 1) % grid.around;
    add_quad(soup, out + j, out + i, in + i, in + j);
    add_quad(soup, out + top + i, out + top + j, in + top + j, in + top + i);
  }
  return soup;
}

Soup make_peg(const primitive::Peg& peg) {
  const double half = 0.5 * peg.length;
  return make_turned([&](double, double) { return 0.5 * peg.diameter; }, -half, half, peg.grid);
}

Soup make_hole(const primitive::Hole& hole) {
  const double half = 0.5 * hole.length;
  return make_bored([&](double theta, double) { return radius_of_square(0.5 * hole.block, theta); },
                    [&](double, double) { return 0.5 * hole.diameter + hole.clearance; }, -half,
                    half, hole.grid);
}

// the flanks are involutes of the base circle (pressure angle 20°), thinned by the backlash
Soup make_gear(const primitive::Gear& gear) {
  const double half = 0.5 * gear.width;
  return make_bored([&](double theta, double) { return gear_radius(gear, theta); },
                    [&](double, double) { return 0.5 * gear.bore; }, -half, half, gear.grid);
}

Soup make_bolt(const primitive::Bolt& bolt) {
  const double half = 0.5 * bolt.length, foot = 0.5 * bolt.diameter - bolt.depth;
  return make_turned(
      [&](double theta, double z) { return foot + bolt.depth * thread_at(bolt.pitch, theta, z); },
      -half, half, bolt.grid);
}

Soup make_nut(const primitive::Nut& nut) {
  const double half = 0.5 * nut.height;
  const double foot = 0.5 * nut.diameter - nut.depth + nut.clearance;
  return make_bored(
      [&](double theta, double) { return radius_of_hexagon(nut.width, theta); },
      [&](double theta, double z) { return foot + nut.depth * thread_at(nut.pitch, theta, z); },
      -half, half, nut.grid);
}

}  // namespace haptic
