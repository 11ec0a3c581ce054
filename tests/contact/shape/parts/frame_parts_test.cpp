// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <numbers>

#include "contact/query/proximity/triangle_pairs.h"
#include "contact/shape/baked/mesh_shape.h"
#include "contact/shape/mesh/primitives.h"
#include "tests/contact/shape/parts/solid.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// Area of a regular polygon of n corners on a circle of radius r.
double polygon(double r, double n) {
  return 0.5 * n * r * r * std::sin(2 * std::numbers::pi / n);
}

/// Volume of a straight frustum over similar polygons.
double frustum(double lower, double upper, double height) {
  return height * (lower + upper + std::sqrt(lower * upper)) / 3;
}

}  // namespace

TEST_CASE("frame parts: solids without self-intersections, by CGAL", "[contact]") {
  check_solid(make_frame_rail({}));
  check_solid(make_pin_rest({}));
  check_solid(make_frame_rail({{.around = 8}}));
  check_solid(make_pin_rest({{.around = 8}}));
  check_solid(make_window({{0.16, 0.13, 0.006}, 0.0426, 0.0346}));
}

TEST_CASE("frame parts: volumes are those of their boxes, holes and pins") {
  const primitive::FrameRail parts;
  const primitive::PinRest under;
  const double w = parts.width, h = parts.height, s = w / 8, n = parts.around;
  const double channel = parts.length - 2 * w, r = 0.5 * parts.diameter + parts.clearance;
  const double hole = polygon(r, n), slot = hole + 4 * r * parts.diameter / 4;
  double rail = 2 * w * w * s - (hole + slot) * s;                   // lugs
  rail += 2 * s * w * h;                                             // ends of the channel
  rail += (channel - 2 * s) * (w * s + 2 * s * (h - s));             // its web and sides
  rail += (0.3 + 0.3) * (0.5 * parts.length - w) * s * (2 * w / 3);  // tabs
  CHECK(volume(make_frame_rail(parts)) == Approx(rail).epsilon(1e-12));
  const double foot = polygon(0.5 * parts.diameter, n), tip = foot / 4;
  const double pin = 1.5 * s * foot + frustum(foot, tip, 0.5 * parts.diameter);
  const double post = 0.75 * w, base = 2 * s * (parts.length + w) * 1.5 * w;
  CHECK(volume(make_pin_rest(under)) ==
        Approx(base + 2 * post * post * under.height + 2 * pin).epsilon(1e-12));
  CHECK(volume(make_window({{0.16, 0.13, 0.006}, 0.04, 0.03})) ==
        Approx((0.16 * 0.13 - 0.04 * 0.03) * 0.006).epsilon(1e-12));
}

TEST_CASE("frame parts: the rail lies on its pins with the play that is stated") {
  const primitive::FrameRail parts;
  const primitive::PinRest under;
  const MeshShapeData rail = build_shape(make_frame_rail(parts)),
                      rest = build_shape(make_pin_rest(under));
  const double c = parts.clearance, lift = 1e-6;
  const auto is_free = [&](const Vec3& aside, double turn) {
    return triangle_pairs(rest.view(), rail.view(),
                          {aside + Vec3{0, 0, lift}, from_rotation_vector({0, 0, turn})}, {}) == 0;
  };
  CHECK(is_free({}, 0));
  // chords of 48 steps leave 0.2 % less of the radius
  const double chord = 0.5 * parts.diameter * 2.2e-3;
  for (const double side : {-1.0, 1.0}) {
    // the round hole holds along x, both hold along y; the slot lets go by a turn about the hole
    CHECK(is_free({side * (c - chord), 0, 0}, 0));
    CHECK_FALSE(is_free({side * (c + chord), 0, 0}, 0));
    CHECK(is_free({0, side * (c - chord), 0}, 0));
    CHECK_FALSE(is_free({0, side * (c + chord), 0}, 0));
    const double turn = c / (0.5 * (parts.length - parts.width));
    CHECK(is_free({}, side * 0.9 * turn));
    CHECK_FALSE(is_free({}, side * 1.1 * turn));
  }
}
