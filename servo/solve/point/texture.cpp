// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/point/texture.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kTwoPi = 6.283185307179586;  // [rad]
constexpr double kMostSamples = 16;           // along the path of a tick
constexpr double kGratingSamples = 8;         // per wavelength
constexpr double kPixelSamples = 2;           // per pixel
constexpr double kWhite = 255;                // grey level of full height

double pixel(const HeightImage& image, double column, double row) {
  HAPTIC_ASSERT(image.width > 0 && image.width <= HeightImage::kMaxSide);
  HAPTIC_ASSERT(image.height > 0 && image.height <= HeightImage::kMaxSide);
  const auto wrapped = [](double i, uint32_t n) {
    return static_cast<uint32_t>(i - n * std::floor(i / n)) % n;
  };
  return image.grey[wrapped(row, image.height) * image.width + wrapped(column, image.width)];
}

/// Slopes of the bilinear surface in grey levels per pixel, along columns and along rows.
struct Slopes {
  double column, row;
};

Slopes image_slopes(const HeightImage& image, double x, double y) {
  const double column = std::floor(x), row = std::floor(y);
  const double u = x - column, v = y - row;
  const double h00 = pixel(image, column, row), h10 = pixel(image, column + 1, row);
  const double h01 = pixel(image, column, row + 1), h11 = pixel(image, column + 1, row + 1);
  return {(1 - v) * (h10 - h00) + v * (h11 - h01), (1 - u) * (h01 - h00) + u * (h11 - h10)};
}

Vec3 image_gradient(const TextureConfig& texture, const HeightImage& image, const Vec3& p_O,
                    const Vec3& normal_O) {
  const Vec3 n{std::fabs(normal_O.x), std::fabs(normal_O.y), std::fabs(normal_O.z)};
  const int axis = n.x >= n.y && n.x >= n.z ? 0 : n.y >= n.z ? 1 : 2;
  const int across = (axis + 1) % 3, down = (axis + 2) % 3;
  const double side = texture.period / image.width;
  const Slopes slopes = image_slopes(image, p_O[across] / side, p_O[down] / side);
  Vec3 gradient;
  gradient[across] = texture.amplitude / kWhite * slopes.column / side;
  gradient[down] = texture.amplitude / kWhite * slopes.row / side;
  return gradient;
}

/// Spacing of samples fine enough for the texture [m].
double sample_spacing(const TextureConfig& texture, std::span<const HeightImage> images) {
  return texture.kind == TextureKind::kGrating
             ? texture.period / kGratingSamples
             : texture.period / (kPixelSamples * images[texture.image].width);
}

}  // namespace

Vec3 height_gradient(const TextureConfig& texture, std::span<const HeightImage> images,
                     const Vec3& p_O, const Vec3& normal_O) {
  if (texture.kind == TextureKind::kNone) return {};
  HAPTIC_ASSERT(texture.period > 0);
  HAPTIC_ASSERT(texture.kind != TextureKind::kImage || texture.image < images.size());
  if (texture.kind == TextureKind::kImage) {
    return image_gradient(texture, images[texture.image], p_O, normal_O);
  }
  const double wave_number = kTwoPi / texture.period;
  const double slope =
      texture.amplitude * wave_number * std::cos(wave_number * dot(texture.direction_O, p_O));
  return slope * texture.direction_O;
}

Vec3 steepest_gradient(const TextureConfig& texture, std::span<const HeightImage> images,
                       const TexturePath& path) {
  Vec3 steepest = height_gradient(texture, images, path.to_O, path.normal_O);
  if (texture.kind == TextureKind::kNone) return steepest;
  const Vec3 way_O = path.to_O - path.from_O;
  const double spacing = sample_spacing(texture, images);
  const double n = std::min(std::ceil(norm(way_O) / spacing), kMostSamples);
  for (double i = 1; i < n; ++i) {
    const Vec3 gradient =
        height_gradient(texture, images, path.from_O + (i / n) * way_O, path.normal_O);
    if (norm_squared(gradient) > norm_squared(steepest)) steepest = gradient;
  }
  return steepest;
}

Vec3 tilted_normal(const Vec3& normal, const Vec3& gradient) {
  return normalized(normal - gradient + dot(gradient, normal) * normal);
}

}  // namespace haptic
