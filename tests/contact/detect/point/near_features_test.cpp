// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point/near_features.h"

#include <catch2/catch.hpp>
#include <map>
#include <numbers>

#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// Features that all adjacent triangles agree are nearest, with p in front.
std::map<uint64_t, double> brute_features(const TriangleMesh& mesh, const Vec3& p, double radius) {
  std::map<uint64_t, std::pair<size_t, ClosestPoint>> agreeing;
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const ClosestPoint c = closest_point_on_triangle(mesh, i, p);
    if (norm_squared(p - c.point_O) >= radius * radius) continue;
    auto& [count, closest] = agreeing[c.feature.id()];
    if (count++ == 0) closest = c;
  }
  std::map<uint64_t, double> features;
  for (const auto& [id, found] : agreeing) {
    const auto& [count, closest] = found;
    size_t around = 1;
    if (closest.feature.kind == FeatureKind::kVertex) {
      around = mesh.vertex_valence[closest.feature.index];
    } else if (closest.feature.kind == FeatureKind::kEdge) {
      around = mesh.edge_faces[closest.feature.index][1] == kNoFace ? 1 : 2;
    }
    const bool in_front = dot(p - closest.point_O, pseudo_normal(mesh, closest.feature)) >= 0;
    if (count == around && in_front) features[id] = closest.distance;
  }
  return features;
}

void compare_with_brute_force(const MeshShapeData& shape, uint64_t seed, size_t n) {
  Random random(seed);
  const MeshShape view = shape.view();
  const double size = norm(view.mesh.upper - view.mesh.lower);
  NearScratch scratch;
  std::vector<NearFeature> out(kMaxNearTriangles);
  size_t total = 0, complete = 0;
  for (size_t i = 0; i < n; ++i) {
    const double off = std::pow(10, random.uniform(-9, -0.5)) * size;
    const Vec3 p = random.on_surface(view.mesh) + off * random.direction();
    const double radius = random.uniform(0, 0.3) * size;
    const auto expected = brute_features(view.mesh, p, radius);
    const NearResult near = near_features(view, p, radius, scratch, out);
    CAPTURE(i, p, radius);
    // a broken mesh may have more near triangles than fit: then there is no guarantee
    if (near.truncated) continue;
    ++complete;
    std::map<uint64_t, double> found;
    for (size_t k = 0; k < near.count; ++k) {
      found[out[k].closest.feature.id()] = out[k].closest.distance;
      if (k > 0) REQUIRE(out[k - 1].closest.distance <= out[k].closest.distance);
    }
    REQUIRE(found == expected);
    total += found.size();
  }
  CHECK(total > 0);
  CHECK(2 * complete > n);
}

/// A field of hills, n × n quads over 0.1 m × 0.1 m.
Soup make_hills(uint32_t n) {
  Soup soup = make_grid(0.05, n);
  for (Vec3& v : soup.vertices) v.z = 2e-3 * std::sin(300 * v.x) * std::cos(250 * v.y);
  return soup;
}

}  // namespace

TEST_CASE("near features: those that brute force over all triangles finds") {
  compare_with_brute_force(build_shape(make_box({0.1, 0.2, 0.05})), 1, trials(4000));
  compare_with_brute_force(build_shape(make_icosphere(0.05, 3)), 2, trials(1000));
  compare_with_brute_force(build_shape(make_hills(24)), 3, trials(1000));
  const Soup bunny = load_off("bunny00.off", 0.1);
  if (!bunny.triangles.empty()) compare_with_brute_force(build_shape(bunny), 4, trials(100));
}

TEST_CASE("near features: on rough sheets, where normals turn by more than 45° within a patch") {
  for (const double slope : {0.5, 1.0, 2.0, 4.0}) {
    compare_with_brute_force(build_shape(make_rough_sheet(7, 20, slope)), 7, trials(1000));
  }
}

TEST_CASE("near features: on a broken mesh and on loose triangles too") {
  compare_with_brute_force(build_shape(make_degenerate_soup(5, 60)), 5, trials(2000));
  const Soup bones = load_off("bones.off", 0.1);
  if (!bones.triangles.empty()) compare_with_brute_force(build_shape(bones), 6, trials(100));
}

TEST_CASE(
    "near features: of a box the face, the edge or the vertex before it, of a room two walls") {
  struct Case {
    Vec3 p;
    double radius;
    std::vector<std::pair<FeatureKind, Vec3>> expected;
  };
  const MeshShapeData box = build_shape(make_box({0.1, 0.1, 0.1})),
                      room = build_shape(turned_inside_out(make_box({0.2, 0.2, 0.2})));
  const auto has = [](const MeshShapeData& shape, const Case& c) {
    NearScratch scratch;
    std::vector<NearFeature> out(16);
    const NearResult near = near_features(shape.view(), c.p, c.radius, scratch, out);
    REQUIRE(near.count == c.expected.size());
    for (size_t i = 0; i < near.count; ++i) {
      CHECK(out[i].closest.feature.kind == c.expected[i].first);
      CHECK_THAT(out[i].normal_O, IsNear(c.expected[i].second, 1e-12));
    }
  };
  has(box, {{0.03, 0.02, 0.051}, 0.05, {{FeatureKind::kFace, {0, 0, 1}}}});
  has(box, {{0.053, 0.01, 0.054}, 0.02, {{FeatureKind::kEdge, {0.6, 0, 0.8}}}});
  has(box, {{0.06, 0.06, 0.06}, 0.03, {{FeatureKind::kVertex, normalized(Vec3{1, 1, 1})}}});
  has(room, {{0.097, 0.096, 0.01},
             0.01,
             {{FeatureKind::kFace, {-1, 0, 0}}, {FeatureKind::kFace, {0, -1, 0}}}});
}

TEST_CASE("near features: a pit is not felt from behind, a plate is on both sides") {
  const MeshShapeData box = build_shape(make_box({0.1, 0.1, 0.001}));
  NearScratch scratch;
  std::vector<NearFeature> out(16);
  REQUIRE(near_features(box.view(), {0.01, 0.02, 0.001}, 0.01, scratch, out).count == 1);
  CHECK(out[0].normal_O.z == Approx(1));
  REQUIRE(near_features(box.view(), {0.01, 0.02, -0.001}, 0.01, scratch, out).count == 1);
  CHECK(out[0].normal_O.z == Approx(-1));
  // from inside, every face is a back face
  CHECK(near_features(box.view(), {0.01, 0.02, 0}, 0.01, scratch, out).count == 0);
}

TEST_CASE("near features: a finer mesh of the same surface fills no list") {
  NearScratch scratch;
  std::vector<NearFeature> out(16);
  std::vector<ClosestPoint> triangles(100000);
  for (const uint32_t n : {50u, 100u, 200u}) {
    const MeshShapeData shape = build_shape(make_hills(n));
    const Vec3 p{0.0123, 0.0171, 5e-3};
    const NearResult near = near_features(shape.view(), p, 8e-3, scratch, out);
    CAPTURE(n, triangles_within(shape.view(), p, 8e-3, triangles));
    CHECK_FALSE(near.truncated);
    CHECK(near.count >= 1);
    CHECK(triangles_facing(shape.view(), p, 8e-3, triangles) <= 32);
  }
}

TEST_CASE("near features: where there is no room for all the nearest are told") {
  const MeshShapeData shape = build_shape(make_rough_sheet(7, 20, 1.0));
  NearScratch scratch;
  std::vector<NearFeature> all(kMaxNearTriangles), few(2);
  const Vec3 p{0.001, 0.002, 0.03};
  const NearResult whole = near_features(shape.view(), p, 0.05, scratch, all);
  REQUIRE_FALSE(whole.truncated);
  REQUIRE(whole.count > few.size());
  const NearResult part = near_features(shape.view(), p, 0.05, scratch, few);
  CHECK_FALSE(part.truncated);
  CHECK(part.left_out == whole.count - few.size());
  REQUIRE(part.count == few.size());
  for (size_t k = 0; k < few.size(); ++k) {
    CAPTURE(k);
    CHECK(few[k].closest.distance == all[k].closest.distance);
    CHECK(few[k].closest.feature == all[k].closest.feature);
  }
}

TEST_CASE("near features: NaN and nothing within reach give none") {
  const MeshShapeData box = build_shape(make_box({0.1, 0.1, 0.1}));
  NearScratch scratch;
  std::vector<NearFeature> out(16);
  const double nan = std::nan("");
  CHECK(near_features(box.view(), {nan, 0, 0}, 1, scratch, out).count == 0);
  CHECK(near_features(box.view(), {0.1, 0, 0}, nan, scratch, out).count == 0);
  CHECK(near_features(box.view(), {0.1, 0, 0}, 0.01, scratch, out).count == 0);
  CHECK(near_features(build_shape({}).view(), {0.1, 0, 0}, 1, scratch, out).count == 0);
}
