// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "clients/lab/eval/scenes/workload.h"

namespace haptic {

inline constexpr double kRestRadius = 0.05;  // mean radius of the objects [m]

/// Motion of a hand that presses a tool into an object of 0.1 m around the origin.
enum class RestHand {
  kReach,   // between places in and around the object, up to 0.5 m/s
  kSlap,    // at 1.5 m/s to a place inside, pause, and out again
  kTremor,  // 5 mm deep, wandering slowly, with 1 mm of tremor at 10 Hz
  kCreep    // 2 mm deep, at 5 mm/s
};
inline constexpr std::array kRestHands{RestHand::kReach, RestHand::kSlap, RestHand::kTremor,
                                       RestHand::kCreep};
std::string name_of(RestHand hand);

/// A closed spiky mesh: a geodesic sphere of 20 f² triangles and 50 mm radius whose vertices are
/// scaled by random factors of 1 ± roughness. It is star-shaped, so it does not intersect itself.
Soup make_spiky_sphere(uint32_t f, double roughness, uint64_t seed);

/// A closed mesh with channels and many small edges: a wall around the gyroid sin x cos y +
/// sin y cos z + sin z cos x = 0 within a ball of 50 mm, by marching tetrahedra (Doi & Koide 1991)
/// on n³ cubes.
Soup make_gyroid(uint32_t n);

/// The path of such a hand for `ticks` ticks of 1 ms, which starts outside. `surface`: mean radius
/// [m].
ToolPath rest_path(RestHand hand, double surface, uint64_t ticks, uint64_t seed);

}  // namespace haptic
