// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "contact/shape/mesh/primitives.h"
#include "contact/shape/parts/vessel.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

// Both chewing surfaces follow one surface z = h(x, y), the mean of the smooth upper envelope of
// cones under the lower cusps and the smooth lower envelope of cones over the upper ones, with
// wrinkles: fissures are where cones meet, and a cusp lies in the pit of the other tooth. Towards
// its rim each crown retreats from h. The lower one is nowhere above h, the upper one nowhere below
// h + clearance, so they touch over most of the surface that they share.

// All shapes below are in millimetres of a lower crown that is 11 mm wide.
constexpr double kWidth = 11;
constexpr double kSlope = 0.85;      // of the cones: 40 degrees
constexpr double kTipRadius = 0.45;  // of a cusp's tip
constexpr double kSeam = 0.1;        // width over which two cones merge: the radius of a fissure

struct Cusp {
  double x, y, z;
};
// cheek side from front to back, then tongue side
constexpr std::array<Cusp, 5> kLowerCusps{
    {{2.7, 3.1, 0}, {2.8, -0.5, 0}, {2.3, -3.7, -0.2}, {-2.7, 2.4, 0.3}, {-2.6, -2.0, 0.2}}};
constexpr std::array<Cusp, 4> kUpperCusps{
    {{5.3, 1.3, -2.3}, {5.1, -2.3, -2.2}, {-0.1, 0.3, -2.4}, {0, -3.6, -2.1}}};

/// The outline of a crown: a superellipse of exponent 2.6, wider in front by `taper`.
struct Crown {
  double x, y;            // its middle
  double half_x, half_y;  // its half axes
  double taper;
  double height;    // from the origin to the neck, along z
  double retreat;   // from h at the rim
  double vertical;  // 1: it stands on its neck, -1: it hangs from it
};
constexpr Crown kLower{0, 0, 5.1, 5.5, 0.05, 8, 1.3, 1};
constexpr Crown kUpper{1.6, -0.5, 5.7, 5.2, 0.03, 6, 1.3, -1};

/// Height under a cone of a rounded tip, at a distance from its axis.
double cone(const Cusp& cusp, double x, double y) {
  const double d2 = (x - cusp.x) * (x - cusp.x) + (y - cusp.y) * (y - cusp.y);
  return kSlope * (std::sqrt(d2 + kTipRadius * kTipRadius) - kTipRadius);
}

/// Smooth maximum of the cones under the cusps, or, with sign -1, minimum of those over them.
double envelope(std::span<const Cusp> cusps, double sign, double x, double y) {
  double most = -1e9, sum = 0;
  for (const Cusp& c : cusps) most = std::max(most, sign * c.z - cone(c, x, y));
  for (const Cusp& c : cusps) sum += std::exp((sign * c.z - cone(c, x, y) - most) / kSeam);
  return sign * (most + kSeam * std::log(sum));
}

/// Enamel is not smooth: waves of 30 and 8 µm amplitude, 1.2 and 0.5 mm long, in directions that
/// do not repeat each other.
double wrinkles(double x, double y) {
  const double coarse =
      std::sin(5.2 * x + 1.3 * std::sin(1.7 * y)) * std::sin(4.9 * y + 1.1 * std::sin(2.1 * x));
  const double fine = std::sin(11.3 * x - 5.1 * y) * std::sin(3.7 * x + 12.1 * y);
  return 0.03 * coarse + 0.008 * fine;
}

/// The surface h that the two share.
double occlusal(double x, double y) {
  return 0.5 * (envelope(kLowerCusps, 1, x, y) + envelope(kUpperCusps, -1, x, y)) + wrinkles(x, y);
}

/// Distance of the outline from the crown's middle, towards θ.
double outline(const Crown& crown, double theta) {
  constexpr double kExponent = 2.6;
  const double c = std::fabs(std::cos(theta)) / crown.half_x;
  const double s = std::fabs(std::sin(theta)) / crown.half_y;
  const double r = std::pow(std::pow(c, kExponent) + std::pow(s, kExponent), -1 / kExponent);
  return r * (1 + crown.taper * std::sin(theta));
}

/// A point of the chewing surface, at a share of the way to the outline.
Vec3 on_top(const Crown& crown, double lift, double share, double theta) {
  constexpr double kRound = 0.74;  // where the rim begins
  const double r = share * outline(crown, theta);
  const double x = crown.x + r * std::cos(theta), y = crown.y + r * std::sin(theta);
  const double rim = std::max(0.0, (share - kRound) / (1 - kRound));
  return {x, y, occlusal(x, y) + lift - crown.vertical * crown.retreat * rim * rim};
}

/// A point of the side, at a share of the way from the rim to the neck, which is narrower.
Vec3 on_side(const Crown& crown, double lift, double share, double theta) {
  const double inward = 1 - 0.2 * share * share, r = inward * outline(crown, theta);
  const double rim = on_top(crown, lift, 1, theta).z, neck = -crown.vertical * crown.height;
  return {crown.x + r * std::cos(theta), crown.y + r * std::sin(theta), rim + share * (neck - rim)};
}

Soup make_crown(const Crown& crown, double lift, const primitive::LowerMolar& molar) {
  HAPTIC_ASSERT(molar.around >= 6 && molar.width > 0);
  const uint32_t rings = molar.around / 6, rows = std::max(1u, molar.around / 11);
  const double scale = molar.width / kWidth;
  const auto at = [&](uint32_t ring, double theta) {
    if (ring <= rings) return scale * on_top(crown, lift / scale, 1.0 * ring / rings, theta);
    return scale * on_side(crown, lift / scale, 1.0 * (ring - rings) / rows, theta);
  };
  const Vec3 neck = scale * Vec3{crown.x, crown.y, -crown.vertical * crown.height};
  return make_vessel(at, neck, {rings, rows}, crown.vertical < 0);
}

}  // namespace

Soup make_lower_molar(const primitive::LowerMolar& molar) {
  return make_crown(kLower, 0, molar);
}

Soup make_upper_molar(const primitive::UpperMolar& molar) {
  return make_crown(kUpper, molar.clearance, molar);
}

}  // namespace haptic
