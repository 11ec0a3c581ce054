// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/soft_contacts.h"

#include "contact/detect/body/cluster_pushes.h"
#include "tests/support/near.h"
#include "tests/support/rigid.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// A tool with many points pressed into a wavy floor, each with its own normal.
struct Patch {
  std::vector<PointPush> pushes;  // in W: sums do not depend on the frame
  ContactSet set{};
  ToolBody tool = kUnknownTool;
};

Patch make_patch(uint64_t seed, double tilt, const Pose& X_WO) {
  Random random(seed);
  Patch patch;
  patch.tool.centre_T = {1e-3, 2e-3, 5e-3};
  patch.set.X_WT = {{0.01, 0.02, 0.03}, from_rotation_vector({0.2, -0.1, 0.3})};
  patch.set.objects.resize(2);
  patch.set.wrench_object = 1;
  patch.set.objects[1].X_WO = X_WO;
  patch.set.trust_radius = 1e-3;
  for (int i = 0; i < 60; ++i) {
    const Vec3 at = patch.set.X_WT.p + 0.02 * random.in_box({-1, -1, -0.1}, {1, 1, 0.1});
    const Vec3 n = normalized(Vec3{0, 0, 1} + tilt * random.direction());
    patch.pushes.push_back({at, n, random.uniform(2e-4, 6e-4), 50});
  }
  const LinearPush sum = sum_pushes(patch.pushes, patch.set.X_WT.p);
  patch.set.F0_W = sum.F0_O;
  patch.set.K = sum.K.a;
  std::array<PushCluster, 16> clusters;
  ClusterMemory memory;
  const size_t n = cluster_pushes(patch.pushes, {1e-2, 0.5}, memory, clusters);
  patch.set.contacts.resize(n);
  patch.set.n_active = static_cast<uint32_t>(n);
  const Pose X_OW = inverse(X_WO), X_TW = inverse(patch.set.X_WT);
  for (size_t i = 0; i < n; ++i) {
    Contact& c = patch.set.contacts[i];
    c.tool_point_T = X_TW * clusters[i].point_O;
    c.object_point_O = X_OW * (clusters[i].point_O + clusters[i].depth * clusters[i].normal_O);
    c.normal_O = rotate(X_OW.q, clusters[i].normal_O);
    c.object = 1;
    c.stiffness = clusters[i].stiffness;
  }
  return patch;
}

SoftCarry carry_at(const Pose& X_WO = {}) {
  SoftCarry carry;
  carry.X_WO = {Pose{}, X_WO};
  carry.V_WO.resize(2);
  return carry;
}

/// All points as springs that move with the tool, the answer of a new query, about C.
Wrench all_points(const Patch& patch, const Twist& motion_of_origin, const Vec3& centre_W) {
  std::vector<PointPush> moved = patch.pushes;
  for (PointPush& p : moved) {
    const Vec3 arm = p.point_O - patch.set.X_WT.p;
    p.depth -= dot(p.normal_O, motion_of_origin.v + cross(motion_of_origin.w, arm));
  }
  return sum_pushes(moved, centre_W).F0_O;
}

Wrench model_at(const SoftContacts& contacts, const ToolBody& tool, const Pose& X_WC) {
  return soft_contact_wrench(contacts.view(), {X_WC, {}}).F_W +
         rest_wrench(contacts, tool, X_WC, {X_WC, {}}).F_W;
}

}  // namespace

TEST_CASE("soft contacts: springs and rest are the linearised wrench, against asking again",
          "[servo][trap]") {
  Random random(3);
  const Pose X_WO = random.pose(0.1);
  const Patch patch = make_patch(1, 0.3, X_WO);
  const SoftContacts contacts = carry_soft_contacts(patch.set, patch.tool, carry_at(X_WO));
  REQUIRE(contacts.finite);
  REQUIRE(contacts.has_rest);
  const Pose X_WC = motion_of_centre(patch.tool, {patch.set.X_WT, {}}).X_WC;
  const Wrench there = model_at(contacts, patch.tool, X_WC), exact = all_points(patch, {}, X_WC.p);
  CHECK_THAT(there.f, IsNear(exact.f, 1e-9));
  CHECK_THAT(there.t, IsNear(exact.t, 1e-10));
  for (int i = 0; i < 100; ++i) {
    // pressing and rotating a little: the change to first order
    const Twist motion{2e-6 * random.direction() - Vec3{0, 0, 2e-6}, 2e-5 * random.direction()};
    const Pose X_WT{patch.set.X_WT.p + motion.v, from_rotation_vector(motion.w) * patch.set.X_WT.q};
    const Pose X_there = motion_of_centre(patch.tool, {X_WT, {}}).X_WC;
    const Wrench again = all_points(patch, motion, X_WC.p),
                 model = model_at(contacts, patch.tool, X_there);
    const double change = norm(again.f - exact.f);
    CHECK(norm(model.f - again.f) <= 0.02 * change + 1e-6);
  }
}

TEST_CASE("soft contacts: retreat is never attractive", "[servo][trap]") {
  // at 0.5 m/s with contact at 100 Hz the tool is 5 mm from its linearisation
  Random random(4);
  const Patch patch = make_patch(2, 0.2, {});
  const SoftContacts contacts = carry_soft_contacts(patch.set, patch.tool, carry_at());
  for (int i = 0; i < 2000; ++i) {
    const double t = random.uniform(0, 10e-3);
    const Vec3 away = normalized(Vec3{0, 0, 1} + 0.5 * random.direction());
    const Pose X_WT{patch.set.X_WT.p + 0.5 * t * away,
                    from_rotation_vector(t * 5 * random.direction()) * patch.set.X_WT.q};
    const Pose X_WC = motion_of_centre(patch.tool, {X_WT, {}}).X_WC;
    const Wrench F = model_at(contacts, patch.tool, X_WC);
    CAPTURE(t, F.f);
    REQUIRE(F.f.z >= -1e-9);
  }
  // far away no force is left
  const Pose far{patch.set.X_WT.p + Vec3{0, 0, 5e-3}, patch.set.X_WT.q};
  CHECK(model_at(contacts, patch.tool, motion_of_centre(patch.tool, {far, {}}).X_WC) == Wrench{});
}

TEST_CASE("soft contacts: they move with their object", "[servo]") {
  Random random(5);
  const Pose X_WO = random.pose(0.1),
             by = {{0.05, -0.02, 0.01}, from_rotation_vector({0.5, 0.3, -0.2})};
  const Patch patch = make_patch(3, 0.3, X_WO);
  const SoftCarry here = carry_at(X_WO), there = carry_at(by * X_WO);
  const Pose X_WC = motion_of_centre(patch.tool, {patch.set.X_WT, {}}).X_WC;
  const Pose aside = moved(X_WC, {{1e-5, 0, -2e-5}, {0, 1e-4, 0}});
  const Wrench before =
      model_at(carry_soft_contacts(patch.set, patch.tool, here), patch.tool, aside);
  const Wrench after =
      model_at(carry_soft_contacts(patch.set, patch.tool, there), patch.tool, by * aside);
  CHECK_THAT(after.f, IsNear(rotate(by.q, before.f), 1e-10));
  CHECK_THAT(after.t, IsNear(rotate(by.q, before.t), 1e-11));
}

TEST_CASE("soft contacts: what is not finite gives none", "[servo]") {
  Patch patch = make_patch(4, 0.2, {});
  patch.set.contacts[1].normal_O.x = std::nan("");
  const SoftContacts bad = carry_soft_contacts(patch.set, patch.tool, carry_at());
  CHECK_FALSE(bad.finite);
  CHECK(bad.size == 0);
  patch = make_patch(4, 0.2, {});
  patch.set.K[3] = std::numeric_limits<double>::infinity();
  CHECK_FALSE(carry_soft_contacts(patch.set, patch.tool, carry_at()).has_rest);
  // the object of the wrench, and of the contacts, is not there
  patch = make_patch(4, 0.2, {});
  CHECK_FALSE(carry_soft_contacts(patch.set, patch.tool, {}).finite);
  patch.set.wrench_object = 2;
  CHECK_FALSE(carry_soft_contacts(patch.set, patch.tool, carry_at()).has_rest);
  SoftCarry stale = carry_at();
  stale.weight = 0;
  CHECK(carry_soft_contacts(make_patch(4, 0.2, {}).set, patch.tool, stale).size == 0);
}
