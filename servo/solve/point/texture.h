// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "proto/config/config.h"

namespace haptic {

/// Path of the contact point over the object in one tick.
struct TexturePath {
  Vec3 from_O, to_O;
  Vec3 normal_O;  // of the surface
};

/// Gradient of the height field h of a texture at p_O, in O. Grating: h = a sin(2π u·p/λ). Image:
/// planar projection along the axis of O nearest to the normal, one tile per period, bilinear
/// between pixels, repeated.
Vec3 height_gradient(const TextureConfig& texture, std::span<const HeightImage> images,
                     const Vec3& p_O, const Vec3& normal_O);

/// The steepest gradient along the path: its end alone would miss a line finer than the path of one
/// tick (Ruspini et al. 1997). At most 16 samples.
Vec3 steepest_gradient(const TextureConfig& texture, std::span<const HeightImage> images,
                       const TexturePath& path);

/// Normal of the textured surface, M = N − ∇h + (∇h·N) N, unit (Basdogan, Ho, Srinivasan 1997).
Vec3 tilted_normal(const Vec3& normal, const Vec3& gradient);

}  // namespace haptic
