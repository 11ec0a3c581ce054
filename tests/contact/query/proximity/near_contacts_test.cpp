// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/near_contacts.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <set>

#include "contact/query/proximity/mesh_distance.h"
#include "contact/query/proximity/near_front.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

std::vector<NearPair> near(const MeshShapeData& A, const MeshShapeData& B, const Pose& X_AB,
                           double band) {
  std::vector<NearPair> pairs(near_pairs(A.view(), B.view(), X_AB, band, {}));
  near_pairs(A.view(), B.view(), X_AB, band, pairs);
  return pairs;
}

/// Only coincident contacts are merged.
constexpr NearContactOptions kAll{.cone_slack = 1e-9, .normal = 1e-9, .place = 0};

Feature feature_of_part(const TriangleMesh& mesh, uint32_t triangle, TrianglePart part) {
  const auto k = static_cast<size_t>(part);
  if (k < 3) return {FeatureKind::kVertex, mesh.triangles[triangle][k]};
  if (k < 6) return {FeatureKind::kEdge, mesh.triangle_edges[triangle][k - 3]};
  return {FeatureKind::kFace, triangle};
}

size_t triangles_around(const TriangleMesh& mesh, const Feature& feature) {
  if (feature.kind == FeatureKind::kVertex) return mesh.vertex_valence[feature.index];
  if (feature.kind == FeatureKind::kFace) return 1;
  return mesh.edge_faces[feature.index][1] == kNoFace ? 1 : 2;
}

/// Local minima by another definition: every pair of triangles around both features must name them.
std::set<uint64_t> agreed_minima(const MeshShapeData& A, const MeshShapeData& B,
                                 std::span<const NearPair> pairs, const Pose& X_AB) {
  struct Votes {
    size_t n = 0, all = 0;
    bool faces_outward = true;
  };
  std::map<uint64_t, Votes> votes;
  const TriangleMesh mesh_A = A.mesh.view(), mesh_B = B.mesh.view();
  for (const NearPair& pair : pairs) {
    if (pair.at.distance == 0) continue;
    const Feature a = feature_of_part(mesh_A, pair.triangles.a, pair.at.part_a);
    const Feature b = feature_of_part(mesh_B, pair.triangles.b, pair.at.part_b);
    Votes& of = votes[feature_id(a, b)];
    ++of.n;
    of.all = triangles_around(mesh_A, a) * triangles_around(mesh_B, b);
    const Vec3 way = pair.at.point_b - pair.at.point_a;
    of.faces_outward = dot(way, pseudo_normal(mesh_A, a)) > 0 &&
                       dot(way, rotate(X_AB.q, pseudo_normal(mesh_B, b))) < 0;
  }
  std::set<uint64_t> minima;
  for (const auto& [id, of] : votes) {
    if (of.n == of.all && of.faces_outward) minima.insert(id);
  }
  return minima;
}

}  // namespace

TEST_CASE("near contacts: those on which all triangles around agree") {
  Random random(1);
  const MeshShapeData sheet = build_shape(make_rough_sheet(4, 14, 0.8));
  const MeshShapeData ball = build_shape(make_icosphere(0.03, 2));
  const MeshShapeData box = build_shape(make_box({0.06, 0.05, 0.04}));
  const MeshShapeData* const shapes[] = {&sheet, &ball, &box};
  size_t n_minima = 0;
  for (size_t trial = 0; trial < trials(60); ++trial) {
    const MeshShapeData &A = *shapes[random.index(3)], &B = *shapes[random.index(3)];
    Pose X_AB = random.pose(0);
    const Vec3 out = random.direction();
    // just apart
    do X_AB.p = X_AB.p + 0.002 * out;
    while (triangle_pairs(A.view(), B.view(), X_AB, {}) > 0);
    const std::vector<NearPair> pairs = near(A, B, X_AB, 0.006);
    NearContacts contacts(A.view(), B.view());
    const NearContactSet set = contacts.reduce(pairs, X_AB, kAll);
    const std::set<uint64_t> expected = agreed_minima(A, B, pairs, X_AB);
    CAPTURE(trial);
    REQUIRE(set.minima == expected.size());
    for (const NearContact& c : set.contacts) REQUIRE(expected.count(c.feature) == 1);
    n_minima += expected.size();
  }
  CHECK((n_minima > 60 || kSlowdown > 1));
}

TEST_CASE("near contacts: the nearest is the distance, its normal from A to B") {
  Random random(2);
  const MeshShapeData ball = build_shape(make_icosphere(0.03, 3));
  for (size_t trial = 0; trial < trials(50); ++trial) {
    const Vec3 direction = random.direction();
    const Pose X_AB{0.0605 * direction, random.pose(1).q};
    NearContacts contacts(ball.view(), ball.view());
    const NearContactSet set = contacts.reduce(near(ball, ball, X_AB, 2e-3), X_AB);
    REQUIRE(!set.contacts.empty());
    const NearContact& c = set.contacts[0];
    CHECK(c.distance == mesh_distance(ball.view(), ball.view(), X_AB).at_least);
    CHECK_THAT(c.point_b, IsNear(c.point_a + c.distance * c.normal_A, 1e-12));
    CHECK(dot(c.normal_A, direction) > 0.98);
    CHECK(std::is_sorted(
        set.contacts.begin(), set.contacts.end(),
        [](const NearContact& p, const NearContact& q) { return p.distance < q.distance; }));
  }
}

TEST_CASE("near contacts: a box on a plate stands on its four corners, level or nearly so") {
  const MeshShapeData plate = build_shape(make_box({0.2, 0.2, 0.01}));
  const MeshShapeData box = build_shape(make_box({0.04, 0.03, 0.02}));
  for (const double tilt : {0.0, 1e-4, -5e-4}) {
    const Pose X{{0.013, -0.007, 0.015 + 5e-5}, from_rotation_vector({tilt, 0.7 * tilt, 0})};
    NearContacts contacts(plate.view(), box.view());
    const NearContactSet set = contacts.reduce(near(plate, box, X, 1e-4), X);
    for (const double x : {-0.02, 0.02}) {
      for (const double y : {-0.015, 0.015}) {
        const Vec3 corner = X * Vec3{x, y, -0.01};
        CAPTURE(tilt, x, y);
        CHECK(std::any_of(set.contacts.begin(), set.contacts.end(), [&](const NearContact& c) {
          return norm(c.point_b - corner) < 1e-9 && norm(c.normal_A - Vec3{0, 0, 1}) < 2e-3;
        }));
      }
    }
  }
}

TEST_CASE("near contacts: a contact keeps its feature from pose to pose") {
  const MeshShapeData ball = build_shape(make_icosphere(0.05, 1));
  const MeshShapeData box = build_shape(make_box({0.2, 0.2, 0.01}));
  NearContacts contacts(box.view(), ball.view());
  uint64_t feature = 0;
  for (int tick = 0; tick < 100; ++tick) {
    const Pose X{{0.011 + 1e-5 * tick, 0.02, 0.0551},
                 from_rotation_vector({0.3, 0.2, 1e-4 * tick})};
    const NearContactSet set = contacts.reduce(near(box, ball, X, 5e-3), X);
    REQUIRE(set.contacts.size() == 1);
    if (tick == 0) feature = set.contacts[0].feature;
    CHECK(set.contacts[0].feature == feature);
  }
  CHECK(feature_id({FeatureKind::kEdge, 1}, {FeatureKind::kFace, 2}) !=
        feature_id({FeatureKind::kFace, 1}, {FeatureKind::kEdge, 2}));
  const FeaturePair pair =
      features_of(feature_id({FeatureKind::kVertex, (1u << 30) - 1}, {FeatureKind::kEdge, 7}));
  CHECK((pair.a.kind == FeatureKind::kVertex && pair.a.index == (1u << 30) - 1));
  CHECK((pair.b.kind == FeatureKind::kEdge && pair.b.index == 7));
}

TEST_CASE("near contacts: what is thinned out is stood for, and what has no room is further") {
  const MeshShapeData sheet = build_shape(make_rough_sheet(4, 24, 0.8));
  const Pose X{{0, 0, 0.0022}, from_rotation_vector({3.14159, 0, 0})};
  const std::vector<NearPair> pairs = near(sheet, sheet, X, 3e-3);
  NearContacts all(sheet.view(), sheet.view()), few(sheet.view(), sheet.view());
  const NearContactOptions options;
  const NearContactSet kept = few.reduce(pairs, X, options);
  // as many of the minima as fit
  const NearContactSet minima = all.reduce(pairs, X, {options.cone_slack, 0, 0});
  REQUIRE(kept.minima > NearContacts::kRoom);
  CHECK(minima.contacts.size() == NearContacts::kRoom);
  CHECK(minima.next >= minima.contacts.back().distance);
  const TriangleMesh mesh = sheet.mesh.view();
  const double reach = options.place * norm(mesh.upper - mesh.lower);
  for (const NearContact& c : minima.contacts) {
    const bool stands =
        std::any_of(kept.contacts.begin(), kept.contacts.end(), [&](const NearContact& k) {
          return k.distance <= c.distance && norm(k.point_a - c.point_a) <= reach &&
                 dot(k.normal_A, c.normal_A) >= std::cos(options.normal) - 1e-12;
        });
    CHECK((stands || c.distance >= kept.next));
  }
  for (const NearContact& c : kept.contacts) CHECK(c.distance <= kept.next);
}

TEST_CASE("near contacts: pairs that meet are counted and left") {
  const MeshShapeData ball = build_shape(make_icosphere(0.05, 2));
  const Pose X{{0.09, 0, 0}, {}};
  NearContacts contacts(ball.view(), ball.view());
  const std::vector<NearPair> pairs = near(ball, ball, X, 1e-3);
  const NearContactSet set = contacts.reduce(pairs, X);
  CHECK(set.meeting == triangle_pairs(ball.view(), ball.view(), X, {}));
  CHECK(set.meeting > 0);
  for (const NearContact& c : set.contacts) CHECK(c.distance > 0);
  CHECK(contacts.reduce({}, X).contacts.empty());
}
