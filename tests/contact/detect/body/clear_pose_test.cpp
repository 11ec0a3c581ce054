// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/detect/body/clear_pose.cpp: that nothing pushes within what it calls clear, by
// every point of the tool and by exact intersection.
#include "contact/detect/body/clear_pose.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>

#include "contact/shape/parts/machine_parts.h"
#include "proto/math/motion_metric.h"
#include "tests/support/cgal_pairs.h"
#include "tests/support/soft_loop.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kVoxel = 1e-3;  // [m]

struct ClearPair {
  SoftPair pair;
  VoxelModel voxel;
  ClearanceModel model;
  ClearanceState state{1};
  ClearPair(const Soup& object, const Soup& tool, VoxelForce reading, double offset)
      : pair(object, tool, kVoxel) {
    voxel.shell = pair.shell.view();
    voxel.objects = pair.objects;
    voxel.reading = reading;
    voxel.force.offset = offset;
    ToolBody body{};
    body.centre_T = {0.001, 0, 0};
    for (const Vec3& v : pair.tool.mesh.view().vertices) {
      body.radius = std::max(body.radius, norm(v - body.centre_T));
    }
    model = {pair.tool.view(),
             body,
             0,
             {{pair.object.view(), push_layer(voxel, pair.objects[0], false)}}};
  }
  ClearPose clear(const Pose& from, const Pose& to) {
    const std::array<Pose, 1> X_WO{};
    return clear_pose(model, state, X_WO, from, to);
  }
  /// Points that touch with the tool there, each looked up.
  uint64_t touching(const Pose& X_WT) {
    VoxelState all(voxel);
    BodyQuestion question;
    question.X_WT = X_WT;
    question.X_WO.resize(1);
    question.V_WO.resize(1);
    question.reach = kVoxel;
    const auto set = std::make_unique<ContactSet>();
    detect_voxel(voxel, all, question, *set);
    return all.touching;
  }
  bool meets(const Pose& X_WT) const {
    return !cgal_triangle_pairs(corners(pair.object, {}), corners(pair.tool, X_WT)).empty();
  }
  /// Upper bound of the motion of any point.
  Pose moved_by(const Pose& X_WT, double way, Random& random) const {
    const double share = random.uniform(0, 1);
    const Pose X_WC{X_WT * model.body.centre_T, X_WT.q};
    const Pose X = moved(X_WC, {share * way * random.direction(),
                                (1 - share) * way / model.body.radius * random.direction()});
    return {X.p - rotate(X.q, model.body.centre_T), X.q};
  }

 private:
  static std::vector<std::array<Vec3, 3>> corners(const MeshShapeData& shape, const Pose& X) {
    std::vector<std::array<Vec3, 3>> out;
    const TriangleMesh mesh = shape.mesh.view();
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const Corners c = corners_of(mesh, t, X);
      out.push_back({c[0], c[1], c[2]});
    }
    return out;
  }
};

}  // namespace

TEST_CASE("clear pose: within what is clear nothing pushes and nothing meets", "[contact]") {
  const bool reads_field = GENERATE(true, false);
  const Soup ball = make_bumpy_ball(0.03, 3), tool = make_bumpy_ball(0.015, 2);
  ClearPair c(ball, tool, reads_field ? VoxelForce::kField : VoxelForce::kTangentPlanes,
              2 * kVoxel);
  Random random(5);
  size_t n_clear = 0;
  double shares = 0;
  for (size_t trial = 0; trial < trials(120); ++trial) {
    const Pose X{random.uniform(0.045, 0.07) * random.direction(), random.pose(1).q};
    const double clearance = c.clear(X, X).clearance[0];
    if (!(clearance > 0)) continue;
    ++n_clear;
    const double layer = c.model.objects[0].layer;
    shares +=
        (clearance + layer) / mesh_distance(c.pair.object.view(), c.pair.tool.view(), X).at_least;
    for (int k = 0; k < 10; ++k) {
      const Pose there = c.moved_by(X, clearance, random);
      REQUIRE(c.touching(there) == 0);
      REQUIRE_FALSE(c.meets(there));
    }
  }
  CHECK(n_clear > trials(120) / 3);
  CHECK(shares > 0.85 * static_cast<double>(n_clear));
}

TEST_CASE("clear pose: leads as far as the way is free", "[contact]") {
  Soup plate = make_box({0.1, 0.1, 0.004});
  ClearPair c(plate, make_box({0.02, 0.02, 0.02}), VoxelForce::kField, 0);
  const Pose above{{0, 0, 0.02}, {}}, far{{0, 0, 0.1}, {}};
  // the whole way is free, with the clearance at its end
  const ClearPose free = c.clear(above, far);
  CHECK(free.X_WT == far);
  CHECK(free.clearance[0] < 0.088);
  CHECK(free.clearance[0] > 0.9 * 0.088 - kVoxel);
  // there is no way through the plate
  const ClearPose held = c.clear(above, {{0, 0, -0.1}, {}});
  CHECK(held.clearance[0] > 0);
  CHECK(held.X_WT.p.z - held.clearance[0] > 0.012);
  CHECK_FALSE(c.meets(held.X_WT));
  // in contact, the clearance is unknown
  const Pose inside{{0, 0, 0.0119}, {}};
  CHECK(c.clear(inside, far).X_WT == inside);
  CHECK(c.clear(inside, far).clearance[0] == 0);
  // half a metre stands for what is further
  CHECK(c.clear({{0, 0, 3}, {}}, {{0, 0, 3}, {}}).clearance[0] == Approx(0.5));
}

TEST_CASE("clear pose: what is too little to be of use is not looked for", "[contact]") {
  ClearPair c(make_box({0.1, 0.1, 0.004}), make_box({0.02, 0.02, 0.02}), VoxelForce::kField, 0);
  const Pose near{{0, 0, 0.0145}, {}}, hand{{0, 0, 0.0146}, {}};
  CHECK(c.clear(near, near).clearance[0] > 1e-3);
  c.model.least = 2e-3;
  CHECK(c.clear(near, near).clearance[0] == 0);
  // but a tool that lags behind its hand is led
  CHECK(c.clear(near, hand).X_WT == hand);
}
