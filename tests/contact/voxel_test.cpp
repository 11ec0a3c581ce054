// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/voxel.h"

#include <memory>

#include "servo/solve/soft_contacts.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kRadius = 0.05;

/// A box as the tool, two balls to touch.
struct Scene {
  MeshShapeData ball = build_shape(make_icosphere(kRadius, 4));
  VoxmapData map = build_voxmap(ball.mesh.view(), {1e-3, 2});
  DistanceFieldData field =
      build_distance_field(-kRadius * Vec3{1, 1, 1}, kRadius* Vec3{1, 1, 1},
                           [](const Vec3& p) { return norm(p) - kRadius; }, {1e-3, 4e-3, 4e-3});
  PointshellData shell =
      build_pointshell(build_shape(make_box({0.03, 0.04, 0.02})).mesh.view(), 1.5e-3);
  std::array<VoxelObject, 2> objects{{{map.view(), field.view()}, {map.view(), field.view()}}};
  VoxelModel model;
  VoxelQuestion question;

  explicit Scene(VoxelForce reading) {
    model.shell = shell.view();
    model.objects = objects;
    model.reading = reading;
    model.force = {500, 10};
    question.X_WO[1].p = {0.2, 0, 0};
  }
};

}  // namespace

TEST_CASE("voxel: clusters and the linearised wrench tell of the same force", "[contact]") {
  const auto reading = GENERATE(VoxelForce::kField, VoxelForce::kTangentPlanes);
  Scene scene(reading);
  VoxelState state(scene.model);
  Random random(1);
  int pressed = 0;
  for (size_t k = 0; k < trials(60); ++k) {
    const Vec3 u = random.direction();
    scene.question.X_WT = {(kRadius + 0.009) * u, from_rotation_vector(random.direction())};
    const auto set = std::make_unique<ContactSet>();
    set->X_WT = scene.question.X_WT;
    set->X_WO = scene.question.X_WO;
    detect_voxel(scene.model, state, scene.question, *set);
    REQUIRE(set->n_contacts <= kMaxContacts);
    if (set->n_active == 0) continue;
    ++pressed;
    REQUIRE(set->wrench_object == 0);
    Vec3 sum;
    for (uint32_t i = 0; i < set->n_active; ++i) {
      const Contact& c = set->contacts[i];
      const Vec3 tool_O = scene.question.X_WT * c.tool_point_T;
      sum += (c.stiffness * dot(c.normal_O, c.object_point_O - tool_O)) * c.normal_O;
    }
    CHECK_THAT(sum, IsNear(set->F0_W.f, 1e-4 * (1 + norm(set->F0_W.f))));
    // it pushes the tool out
    if (reading == VoxelForce::kField) CHECK(dot(set->F0_W.f, u) > 0);
    // the part of the servo: springs and rest give it back
    RigidBody tool;
    SoftCarry carry;
    const SoftContacts contacts = carry_soft_contacts(*set, tool, carry);
    const Wrench again = soft_contact_wrench(contacts.view(), {scene.question.X_WT, {}}).F_W +
                         rest_wrench(contacts, tool, scene.question.X_WT).F_W;
    CHECK_THAT(again.f, IsNear(set->F0_W.f, 1e-9 * (1 + norm(set->F0_W.f))));
    CHECK_THAT(again.t, IsNear(set->F0_W.t, 1e-9 * (1 + norm(set->F0_W.f))));
  }
  CHECK(pressed > static_cast<int>(trials(60)) / 3);
}

TEST_CASE("voxel: a face on a plate has its torque in the clusters alone", "[contact][trap]") {
  // more places than 16 clusters have room for, and sides whose normals are across
  Scene scene(VoxelForce::kField);
  const DistanceFieldData plate =
      build_distance_field({-0.05, -0.05, -2e-3}, {0.05, 0.05, 0},
                           [](const Vec3& p) { return p.z; }, {1e-3, 4e-3, 4e-3});
  scene.objects[0].field = plate.view();
  scene.model.objects = {scene.objects.data(), 1};
  VoxelState state(scene.model);
  for (const double tilt : {0.0, 0.01, -0.01}) {
    scene.question.X_WT = {{0, 0, 0.0098}, from_rotation_vector({tilt, 0, 0.3})};
    const auto set = std::make_unique<ContactSet>();
    detect_voxel(scene.model, state, scene.question, *set);
    REQUIRE(set->n_active > 0);
    Vec3 torque;
    for (uint32_t i = 0; i < set->n_active; ++i) {
      const Contact& c = set->contacts[i];
      const Vec3 arm = rotate(scene.question.X_WT.q, c.tool_point_T);
      const double depth = dot(c.normal_O, c.object_point_O - scene.question.X_WT * c.tool_point_T);
      torque += cross(arm, c.stiffness * depth * c.normal_O);
    }
    CHECK_THAT(torque, IsNear(set->F0_W.t, 2e-4 * norm(set->F0_W.f) * 0.02));
  }
}

TEST_CASE("voxel: what approaches is reported, and pushes nothing", "[contact]") {
  Scene scene(VoxelForce::kField);
  VoxelState state(scene.model);
  scene.question.X_WT = {{0, 0, kRadius + 0.0105}, {}};
  scene.question.reach = 2e-3;
  const auto set = std::make_unique<ContactSet>();
  detect_voxel(scene.model, state, scene.question, *set);
  CHECK(set->n_active == 0);
  REQUIRE(set->n_contacts > 0);
  CHECK(set->trust_radius == 0);
  for (uint32_t i = 0; i < set->n_contacts; ++i) {
    const Contact& c = set->contacts[i];
    CHECK(dot(c.normal_O, c.object_point_O - scene.question.X_WT * c.tool_point_T) < 0);
  }
}

TEST_CASE("voxel: the object pressed hardest comes first", "[contact]") {
  Scene scene(VoxelForce::kField);
  VoxelState state(scene.model);
  // between two balls, nearer to the second
  scene.question.X_WO[1].p = {0.13 - 1e-3, 0, 0};
  scene.question.X_WT = {{0.065 - 0.2e-3, 0, 0}, {}};
  const auto set = std::make_unique<ContactSet>();
  detect_voxel(scene.model, state, scene.question, *set);
  REQUIRE(set->n_active >= 2);
  const uint32_t first = set->wrench_object;
  bool others = false;
  for (uint32_t i = 0; i < set->n_contacts; ++i) {
    others |= set->contacts[i].object != first;
    if (others) CHECK(set->contacts[i].object != first);
  }
  CHECK(others);
}

TEST_CASE("voxel: a short budget is flagged and holds", "[contact]") {
  Scene scene(VoxelForce::kField);
  scene.model.budget = 100;
  VoxelState state(scene.model);
  scene.question.X_WT = {{0, 0, kRadius + 0.009}, {}};
  const auto set = std::make_unique<ContactSet>();
  detect_voxel(scene.model, state, scene.question, *set);
  CHECK((set->flags & kContactIterationLimit) != 0);
  CHECK(state.tested <= 2 * 2 * 100);
  CHECK(set->n_contacts > 0);
}
