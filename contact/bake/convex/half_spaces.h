// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/bake/convex/growing_hull.h"

namespace haptic {

/// A point near p that lies below all planes, up to `tolerance` [m]: again and again it is moved
/// through the one that it lies farthest above, a little beyond it (the relaxation method of Agmon,
/// Motzkin & Schoenberg 1954). Where no point lies below all, or hardly any, this may not either:
/// the caller looks.
Vec3 into_half_spaces(Vec3 p, std::span<const Plane> planes, double tolerance);

}  // namespace haptic
