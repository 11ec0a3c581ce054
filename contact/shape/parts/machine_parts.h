// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// Distance from the z axis [m], > 0, at angle θ [rad] and height z [m].
using RadiusAt = std::function<double(double theta, double z)>;

/// Closed solid between two heights with its side at `outer`: 2·around·(along + 1) triangles.
Soup make_turned(const RadiusAt& outer, double z_lower, double z_upper, const PartGrid& grid);

/// A turned solid with a through hole of radius `inner` < outer.
Soup make_bored(const RadiusAt& outer, const RadiusAt& inner, double z_lower, double z_upper,
                const PartGrid& grid);

}  // namespace haptic
