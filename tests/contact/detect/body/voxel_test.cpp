// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/voxel.h"

#include <memory>

#include "servo/solve/body/soft_contacts.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kRadius = 0.05;

/// A box as the tool, two balls as objects.
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
  BodyQuestion question;

  explicit Scene(VoxelForce reading) {
    model.shell = shell.view();
    model.objects = objects;
    model.reading = reading;
    model.force = {500, 10};
    question.X_WO = {{}, {{0.2, 0, 0}, {}}};
    question.V_WO.resize(2);
  }
  std::unique_ptr<ContactSet> ask(VoxelState& state) const {
    auto set = std::make_unique<ContactSet>();
    set->X_WT = question.X_WT;
    for (const Pose& X_WO : question.X_WO) set->objects.push_back({X_WO, 0});
    detect_voxel(model, state, question, *set);
    return set;
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
    // in any case, or on its lower side, which alone touches
    const bool flat = k % 2 == 0;
    const Vec3 turn = flat ? std::acos(u.z) * normalized(Vec3{-u.y, u.x, 0}) : random.direction();
    scene.question.X_WT = {(kRadius + 0.009) * u, from_rotation_vector(turn)};
    const auto set = scene.ask(state);
    REQUIRE(set->contacts.size() <= kMaxContacts);
    if (set->n_active == 0) continue;
    ++pressed;
    REQUIRE(set->wrench_object == 0);
    Vec3 sum;
    for (uint32_t i = 0; i < set->n_active; ++i) {
      const Contact& c = set->contacts[i];
      const Vec3 tool_O = scene.question.X_WT * c.tool_point_T;
      CHECK(dot(c.normal_O, c.shading_normal_O) >= 0.1);
      sum += (c.stiffness * dot(c.normal_O, c.object_point_O - tool_O)) * c.normal_O;
    }
    if (flat && reading == VoxelForce::kField)
      CHECK_THAT(sum, IsNear(set->F0_W.f, 1e-4 * (1 + norm(set->F0_W.f))));
    // it pushes the tool out
    if (reading == VoxelForce::kField) CHECK(dot(set->F0_W.f, u) > 0);
    // the servo's part: springs and rest reproduce it
    ToolBody tool = kUnknownTool;
    SoftCarry carry;
    carry.X_WO = scene.question.X_WO;
    carry.V_WO.resize(2);
    const SoftContacts contacts = carry_soft_contacts(*set, tool, carry);
    const Wrench again =
        soft_contact_wrench(contacts.view(), {scene.question.X_WT, {}}).F_W +
        rest_wrench(contacts, tool, scene.question.X_WT, {scene.question.X_WT, {}}).F_W;
    // a pulling part, due to clusters across the object's normal, is cut off
    const double cut = flat ? 1e-9 : 0.1;
    CHECK_THAT(again.f, IsNear(set->F0_W.f, cut * (1 + norm(set->F0_W.f))));
    CHECK_THAT(again.t, IsNear(set->F0_W.t, 1e-9 * (1 + norm(set->F0_W.f))));
  }
  CHECK(pressed > static_cast<int>(trials(60)) / 3);
}

TEST_CASE("voxel: a face on a plate has its torque in the clusters alone", "[contact][trap]") {
  // more places than fit into 16 clusters, and sides with perpendicular normals
  Scene scene(VoxelForce::kField);
  const DistanceFieldData plate =
      build_distance_field({-0.05, -0.05, -2e-3}, {0.05, 0.05, 0},
                           [](const Vec3& p) { return p.z; }, {1e-3, 4e-3, 4e-3});
  scene.objects[0].field = plate.view();
  scene.model.objects = {scene.objects.data(), 1};
  VoxelState state(scene.model);
  for (const double tilt : {0.0, 0.01, -0.01}) {
    scene.question.X_WT = {{0, 0, 0.0098}, from_rotation_vector({tilt, 0, 0.3})};
    const auto set = scene.ask(state);
    REQUIRE(set->n_active > 0);
    Vec3 torque;
    for (uint32_t i = 0; i < set->n_active; ++i) {
      const Contact& c = set->contacts[i];
      const Vec3 arm = rotate(scene.question.X_WT.q, c.tool_point_T);
      const double depth = dot(c.normal_O, c.object_point_O - scene.question.X_WT * c.tool_point_T);
      torque += cross(arm, c.stiffness * depth * c.normal_O);
    }
    // the sides' points push across the plate: they appear only in F0 and K
    CHECK_THAT(torque, IsNear(set->F0_W.t, 0.05 * norm(set->F0_W.t) + 2e-6));
  }
}

TEST_CASE("voxel: what approaches is reported, and pushes nothing", "[contact]") {
  Scene scene(VoxelForce::kField);
  VoxelState state(scene.model);
  scene.question.X_WT = {{0, 0, kRadius + 0.0105}, {}};
  scene.question.reach = 2e-3;
  const auto set = scene.ask(state);
  CHECK(set->n_active == 0);
  REQUIRE(set->contacts.size() > 0);
  CHECK(set->trust_radius == 0);
  for (uint32_t i = 0; i < set->contacts.size(); ++i) {
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
  const auto set = scene.ask(state);
  REQUIRE(set->n_active >= 2);
  const uint32_t first = set->wrench_object;
  bool others = false;
  for (uint32_t i = 0; i < set->contacts.size(); ++i) {
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
  const auto set = scene.ask(state);
  CHECK((set->flags & kContactIterationLimit) != 0);
  CHECK(state.tested <= 100);
  CHECK(set->contacts.size() > 0);
}

TEST_CASE("voxel: a box on a plane is n times as stiff, and at most ten points",
          "[contact][trap]") {
  // ∂F/∂z = n·k for 4 to 400 contacts; direct rendering has it in the tests of exact
  const MeshShapeData plate = build_shape(make_box({0.1, 0.1, 0.02}));
  const VoxmapData map = build_voxmap(plate.mesh.view(), {1e-3, 2});
  VoxelIndex top = map.view().index_of({0, 0, 0});
  while (map.view().at({top[0], top[1], top[2] + 1}) != Voxel::kProximity) ++top[2];
  const double height = map.view().centre_of(top).z;
  const std::array<VoxelObject, 1> objects{{{map.view(), {}}}};
  for (const size_t side : {2u, 3u, 4u, 10u, 20u}) {
    PointshellData shell;
    for (size_t i = 0; i < side * side; ++i) {
      shell.x.push_back(2e-3f * static_cast<float>(i % side));
      shell.y.push_back(2e-3f * static_cast<float>(i / side));
      shell.z.push_back(0);
      shell.nx.push_back(0), shell.ny.push_back(0), shell.nz.push_back(1);
    }
    VoxelModel model;
    model.shell = shell.view();
    model.objects = objects;
    model.reading = VoxelForce::kTangentPlanes;
    model.force = {500, 10};
    VoxelState state(model);
    const auto force_at = [&](double depth) {
      BodyQuestion question;
      question.X_WT.p = {-0.02, -0.02, height - depth};
      question.X_WO.resize(1);
      question.V_WO.resize(1);
      const auto set = std::make_unique<ContactSet>();
      set->objects.resize(1);
      detect_voxel(model, state, question, *set);
      // the wrench of the servo's springs
      SoftCarry carry;
      carry.X_WO.resize(1);
      carry.V_WO.resize(1);
      set->X_WT = question.X_WT;
      const SoftContacts contacts = carry_soft_contacts(*set, {}, carry);
      const double springs = soft_contact_wrench(contacts.view(), {question.X_WT, {}}).F_W.f.z;
      CHECK(springs == Approx(set->F0_W.f.z).epsilon(1e-6));
      return set->F0_W.f.z;
    };
    const double n = static_cast<double>(side * side);
    const double slope = (force_at(0.3e-3) - force_at(0.2e-3)) / 0.1e-3;
    CAPTURE(n);
    CHECK(slope == Approx(500 * std::min(n, 10.0)).epsilon(1e-3));
  }
}

TEST_CASE("voxel: the linearised wrench against asking again within the trust radius",
          "[contact][trap]") {
  // a box flat on a plate: its whole lower side stays in contact
  const MeshShapeData plate = build_shape(make_box({0.1, 0.1, 0.02}));
  const DistanceFieldData field =
      build_distance_field({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.01},
                           [](const Vec3& p) { return p.z - 0.01; }, {1e-3, 4e-3, 4e-3});
  const PointshellData shell =
      build_pointshell(build_shape(make_box({0.02, 0.03, 0.02})).mesh.view(), 1e-3);
  const std::array<VoxelObject, 1> objects{{{{}, field.view()}}};
  VoxelModel model;
  model.shell = shell.view();
  model.objects = objects;
  model.force = {5, 1e9, 1e-3};
  VoxelState state(model);
  BodyQuestion question;
  question.X_WO.resize(1);
  question.V_WO.resize(1);
  const auto ask = [&](const Pose& X_WT) {
    question.X_WT = X_WT;
    auto set = std::make_unique<ContactSet>();
    detect_voxel(model, state, question, *set);
    return set;
  };
  // 0.6 mm in the layer
  const Pose X_WT{{0.01, -0.01, 0.0204}, {}};
  const auto here = ask(X_WT);
  REQUIRE(here->n_active > 0);
  Mat6 K;
  K.a = here->K;
  Random random(4);
  for (size_t i = 0; i < trials(200); ++i) {
    // the farthest corner by at most half the depth, so that no point leaves
    const Twist motion{0.1e-3 * random.direction(), 0.009 * random.direction()};
    const Pose there{X_WT.p + motion.v, from_rotation_vector(motion.w) * X_WT.q};
    const Wrench again = ask(there)->F0_W, change = K * motion;
    // the sides' points that come into contact push sideways only
    const double off = again.f.z - here->F0_W.f.z - change.f.z;
    CAPTURE(off, change.f.z, here->F0_W.f.z);
    CHECK(std::fabs(off) <= 0.02 * norm(change.f) + 1e-3 * here->F0_W.f.z);
  }
}

TEST_CASE("voxel: what approaches is braked before it touches, by the relative velocity",
          "[contact][trap]") {
  Scene scene(VoxelForce::kField);
  scene.model.damping = 2;
  scene.model.braking = GENERATE(Braking::kAlongVelocity, Braking::kAlongNormal);
  VoxelState state(scene.model);
  // a millimetre over the ball, which moves towards it
  scene.question.X_WT.p = {0, 0, kRadius + 0.011};
  scene.question.reach = 3e-3;
  scene.question.V_WO[0].v = {0, 0, 0.1};
  const auto near = scene.ask(state);
  REQUIRE(near->contacts.size() > 0);
  CHECK(near->n_active == 0);
  CHECK(near->F0_W == Wrench{});
  CHECK(near->wrench_object == 0);
  Mat6 B;
  B.a = near->B;
  const Wrench brake = B * Twist{{0, 0, -0.1}, {}};
  CHECK(brake.f.z > 0.1);
  // the ball moves away
  scene.question.V_WO[0].v = {0, 0, -0.1};
  CHECK(scene.ask(state)->B == ContactSet{}.B);
}

TEST_CASE("voxel: seen from anywhere it is the same", "[contact][trap]") {
  Scene scene(VoxelForce::kField);
  scene.model.damping = 2;
  scene.question.X_WT = {{0.002, -0.003, kRadius + 0.009}, from_rotation_vector({0.05, 0.1, 0.3})};
  scene.question.V_WT = {{0.01, 0.02, -0.1}, {0.3, 0.1, 0}};
  const BodyQuestion here = scene.question;
  // clusters go on from those of the last frame
  const auto ask = [&] {
    VoxelState state(scene.model);
    return scene.ask(state);
  };
  const auto a = ask();
  REQUIRE(a->n_active > 0);
  const Pose X = Random(3).pose(0.1);
  for (Pose* pose : {&scene.question.X_WT, &scene.question.X_WO[0], &scene.question.X_WO[1]}) {
    *pose = X * *pose;
  }
  scene.question.V_WT = {rotate(X.q, here.V_WT.v), rotate(X.q, here.V_WT.w)};
  const auto b = ask();
  REQUIRE(b->contacts.size() == a->contacts.size());
  const double force = norm(a->F0_W.f);
  CHECK_THAT(b->F0_W.f, IsNear(rotate(X.q, a->F0_W.f), 1e-5 * force));
  CHECK_THAT(b->F0_W.t, IsNear(rotate(X.q, a->F0_W.t), 1e-5 * force * 0.02));
  const auto turned = [&](const std::array<double, 36>& m) {
    Mat6 M;
    M.a = m;
    return rotated(to_matrix(X.q), M);
  };
  const Mat6 K = turned(a->K), B = turned(a->B);
  for (size_t i = 0; i < 36; ++i) {
    CHECK(std::fabs(b->K[i] - K.a[i]) <= 1e-4 * 5000);
    CHECK(std::fabs(b->B[i] - B.a[i]) <= 1e-4 * (1 + std::fabs(B.a[0])));
  }
  for (uint32_t i = 0; i < a->contacts.size(); ++i) {
    CHECK_THAT(b->contacts[i].object_point_O, IsNear(a->contacts[i].object_point_O, 1e-6));
  }
}
