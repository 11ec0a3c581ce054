// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "clients/eval/scenes/workload.h"

namespace haptic {

inline constexpr double kRestRadius = 0.05;  // of what hands press into, about [m]

/// How a hand moves that presses a tool into an object of 0.1 m about the origin.
enum class RestHand {
  kReach,   // to and fro between places in and around the object, up to 0.5 m/s
  kSlap,    // at 1.5 m/s to a place inside, where it stays, and out again
  kTremor,  // 5 mm deep and slowly on, shaken by 1 mm at 10 Hz
  kCreep    // 2 mm deep, at 5 mm/s
};
inline constexpr std::array kRestHands{RestHand::kReach, RestHand::kSlap, RestHand::kTremor,
                                       RestHand::kCreep};
std::string name_of(RestHand hand);

/// Closed, and spiky: a geodesic sphere of 20 f² triangles and 50 mm whose vertices are put at
/// random between 1 − roughness and 1 + roughness of their distance from the middle. It is seen
/// whole from there, so it does not cut itself.
Soup make_spiky_sphere(uint32_t f, double roughness, uint64_t seed);

/// Closed, of channels and many small edges: a wall of the gyroid sin x cos y + sin y cos z +
/// sin z cos x = 0 within a ball of 50 mm, by marching tetrahedra (Doi & Koide 1991) on n³ cubes.
Soup make_gyroid(uint32_t n);

/// Such a hand for so many ticks of 1 ms; begins outside. `surface` is the mean radius [m].
ToolPath rest_path(RestHand hand, double surface, uint64_t ticks, uint64_t seed);

}  // namespace haptic
