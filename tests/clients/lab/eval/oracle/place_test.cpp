// SPDX-License-Identifier: GPL-3.0-or-later
// The placement check, which does not know the path, against closed forms.
#include "clients/lab/eval/oracle/place.h"

#include <catch2/catch.hpp>

#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kRadius = 2e-3;

}  // namespace

TEST_CASE("eval place: behind a surface, by the nearest facet", "[lab]") {
  const MeshShapeData box = build_shape(make_box({0.1, 0.1, 0.1}));
  const FacetBins facets(box.view().mesh);
  CHECK(behind_surface(facets, {0.01, 0.02, 0.049}, 0, 0.01).depth == Approx(0.001));
  CHECK(behind_surface(facets, {0.01, 0.02, 0.051}, 0, 0.01).depth == 0);
  CHECK(behind_surface(facets, {0.01, 0.02, 0.051}, 0, 0.01).is_known);
  CHECK_FALSE(behind_surface(facets, {0, 0, 0}, 0, 0.01).is_known);
  const MeshShapeData plane = build_shape(make_grid(0.1, 5));
  const FacetBins open(plane.view().mesh);
  CHECK(behind_surface(open, {0.01, 0.02, -0.001}, 0, 0.01).depth == Approx(0.001));
  CHECK_FALSE(behind_surface(open, {0.101, 0.02, -0.001}, 0, 0.01).is_known);
}

TEST_CASE("eval place: a sphere nearer than its radius, beside a border too", "[lab]") {
  const MeshShapeData box = build_shape(make_box({0.1, 0.1, 0.1}));
  const FacetBins facets(box.view().mesh);
  CHECK(behind_surface(facets, {0.01, 0.02, 0.0521}, kRadius, 0.01).depth == 0);
  CHECK(behind_surface(facets, {0.01, 0.02, 0.0515}, kRadius, 0.01).depth == Approx(0.5e-3));
  CHECK(behind_surface(facets, {0.01, 0.02, 0.049}, kRadius, 0.01).depth == Approx(3e-3));
  // next to the edge x = z = 50 mm, 1.4 mm away
  CHECK(behind_surface(facets, {0.051, 0.02, 0.051}, kRadius, 0.01).depth ==
        Approx(kRadius - std::sqrt(2.0) * 1e-3));
  const MeshShapeData plane = build_shape(make_grid(0.1, 5));
  const FacetBins open(plane.view().mesh);
  CHECK(behind_surface(open, {0.101, 0.02, -0.0005}, kRadius, 0.01).depth ==
        Approx(kRadius - std::sqrt(1.25) * 1e-3));
}

TEST_CASE("eval place: at rest on a face, not beside its foot", "[lab]") {
  const double radius = GENERATE(0.0, 2e-3);
  const MeshShapeData box = build_shape(make_box({0.1, 0.1, 0.1}));
  const FacetBins facets(box.view().mesh);
  const Vec3 tool{0.01, 0.02, 0.045};
  const Vec3 foot{0.01, 0.02, 0.05 + radius};
  CHECK(free_descent(facets, foot, tool, radius) <= tol(1e-15));
  // displaced by 1 µm, it could go back all the way
  CHECK(free_descent(facets, foot + Vec3{1e-6, 0, 0}, tool, radius) == Approx(1e-6));
  // 10 µm above nothing holds it
  CHECK(free_descent(facets, foot + Vec3{0, 0, 1e-5}, tool, radius) ==
        Approx(norm(foot - tool) + 1e-5));
}

TEST_CASE("eval place: at rest in a corner of two walls", "[lab]") {
  // the cone of two normals: pressed into both it rests, along one it does not
  const double radius = GENERATE(0.0, 2e-3);
  Soup soup;
  soup.vertices = {{0, -1, 0}, {0, 1, 0}, {1, 1, 0}, {1, -1, 0}, {0, -1, 1}, {0, 1, 1}};
  soup.triangles = {{0, 3, 2}, {0, 2, 1}, {0, 1, 5}, {0, 5, 4}};
  const MeshShapeData corner = build_shape(std::move(soup));
  const FacetBins facets(corner.view().mesh);
  const Vec3 rest{radius, 0.1, radius};
  CHECK(free_descent(facets, rest, rest + Vec3{-1e-3, 0, -2e-3}, radius) <= tol(1e-15));
  CHECK(free_descent(facets, rest, rest + Vec3{1e-3, 0, -2e-3}, radius) == Approx(1e-3));
  CHECK(free_descent(facets, rest, rest + Vec3{-1e-3, 3e-3, -2e-3}, radius) == Approx(3e-3));
}

TEST_CASE("eval place: a sphere rests on an edge where the tool is straight below", "[lab]") {
  const MeshShapeData box = build_shape(make_box({0.1, 0.1, 0.1}));
  const FacetBins facets(box.view().mesh);
  const Vec3 edge{0.05, 0, 0.05}, out{0.6, 0, 0.8}, aside{0.8, 0, -0.6};
  const Vec3 rest = edge + kRadius * out;
  CHECK(free_descent(facets, rest, edge + 1e-3 * out, kRadius) <= tol(1e-15));
  CHECK(free_descent(facets, rest, edge + 1e-3 * out + 1e-4 * aside, kRadius) == Approx(1e-4));
}
