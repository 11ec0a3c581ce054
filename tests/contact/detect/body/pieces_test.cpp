// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/detect/body/pieces.cpp and contact/detect/soft_detector.cpp.
#include "contact/detect/body/pieces.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>

#include "contact/bake/convex/piece_tree.h"
#include "tests/support/convex/meshes.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

namespace haptic {
namespace {

using test::IsNear;

constexpr double kReach = 0.5e-3;  // δ [m]
constexpr double kStiffness = 1000;

/// A tool and one object, with their convex pieces.
struct Pair {
  MeshShapeData object, tool;
  PieceTreeData object_pieces, tool_pieces;
  PieceModel model;

  Pair(const Soup& object_soup, const Soup& tool_soup, double cluster_radius)
      : object(build_shape(object_soup)),
        tool(build_shape(tool_soup)),
        object_pieces(build_piece_tree(object.mesh.view())),
        tool_pieces(build_piece_tree(tool.mesh.view())) {
    model.tool = tool_pieces.view();
    model.objects = {object_pieces.view()};
    model.stiffness = kStiffness;
    model.clusters.radius = cluster_radius;
    model.refine.spread = 0.5 * cluster_radius;
    model.search = 0.05;
    model.most_pairs = {1 << 14};
  }
};

/// A detector that goes on from pose to pose.
struct Detector {
  const Pair& pair;
  RefineOptions refine;
  PieceState state;
  std::unique_ptr<ContactSet> set = std::make_unique<ContactSet>();

  explicit Detector(const Pair& of, double threshold = 0)
      : pair(of), refine(of.model.refine), state(of.model) {
    refine.threshold = threshold;
  }

  const ContactSet& at(const Pose& X_WT, const Pose& X_WO = {}) {
    *set = {};
    BodyQuestion question;
    question.X_WT = X_WT;
    question.X_WO = {X_WO};
    question.V_WO.resize(1);
    question.reach = kReach;
    const MeshShape object = pair.object.view();
    detect_pieces(pair.model, refine, {{&object, 1}, pair.tool.view()}, state, question, *set);
    return *set;
  }
};

/// Depth of a contact with the tool and the object where they are [m].
double depth_of(const Contact& c, const Pose& X_WT, const Pose& X_WO = {}) {
  return dot(rotate(X_WO.q, c.normal_O), X_WO * c.object_point_O - X_WT * c.tool_point_T);
}

/// Of the contacts that push, about the tool's origin.
Wrench piece_wrench(const ContactSet& set, const Pose& X_WT, const Pose& X_WO = {}) {
  Wrench sum{};
  for (uint32_t i = 0; i < set.contacts.size(); ++i) {
    const Contact& c = set.contacts[i];
    const double depth = depth_of(c, X_WT, X_WO);
    if (!(depth > 0)) continue;
    const Vec3 force = c.stiffness * depth * rotate(X_WO.q, c.normal_O);
    sum = sum + Wrench{force, cross(rotate(X_WT.q, c.tool_point_T), force)};
  }
  return sum;
}

const Pair& cube_on_plate() {
  static const Pair made(make_box({0.1, 0.1, 0.02}), make_box({0.02, 0.02, 0.02}), 3e-3);
  return made;
}

/// Two bumpy balls of 20 mm, one of which slides and turns on the other.
const Pair& bumps() {
  static const Pair made(test::make_bumpy_ball(0.02, 3, 0.05, 9),
                         test::make_bumpy_ball(0.02, 3, 0.05, 8), 3e-3);
  return made;
}

Pose sliding(double t) {
  return {{0.0394 * std::cos(0.4 * t), 0.0394 * std::sin(0.4 * t), 0.001 * std::sin(7 * t)},
          from_rotation_vector({0.5 * t, 0.3, -0.2 * t})};
}

}  // namespace

TEST_CASE("pieces: a cube pressed on a plate pushes as its four corners do") {
  Detector detector(cube_on_plate());
  for (const double depth : {0.05e-3, 0.2e-3, 0.4e-3}) {
    const Pose X_WT{{0.01, 0.02, 0.02 - depth}, {}};
    const ContactSet& set = detector.at(X_WT);
    CHECK(set.contacts.size() == 4);
    CHECK(set.n_active == 4);
    for (uint32_t i = 0; i < set.contacts.size(); ++i) {
      const Contact& c = set.contacts[i];
      CHECK(depth_of(c, X_WT) == Approx(depth));
      CHECK(c.normal_O.z == Approx(1));
      CHECK(std::fabs(c.tool_point_T.x) == Approx(0.01));
      CHECK(std::fabs(c.tool_point_T.y) == Approx(0.01));
    }
    const Wrench F = piece_wrench(set, X_WT);
    CHECK_THAT(F.f, IsNear({0, 0, 4 * kStiffness * depth}, 1e-6));
    CHECK_THAT(F.t, IsNear({0, 0, 0}, 1e-8));
  }
  // tipped about y by θ, two corners deeper by half of the side · sin θ
  const double tip = 2e-3, depth = 0.1e-3;
  const Pose X_WT{{0, 0, 0.02 - depth}, from_rotation_vector({0, tip, 0})};
  const Wrench F = piece_wrench(detector.at(X_WT), X_WT);
  CHECK(F.t.y < 0);
  CHECK(std::fabs(F.t.x) < 1e-8);
}

TEST_CASE("pieces: while still apart a contact has the depth that it will have, below zero") {
  Detector detector(cube_on_plate());
  // from 1 mm above to 0.3 mm below, and turned so that a corner comes first
  const Quat askew = from_rotation_vector({0.02, 0.03, 0.4});
  double lowest = 0;
  for (const Vec3& v : make_box({0.02, 0.02, 0.02}).vertices) {
    lowest = std::min(lowest, rotate(askew, v).z);
  }
  bool was_reported = false;
  for (int i = 0; i <= 260; ++i) {
    const double height = 1e-3 - 5e-6 * i;  // of the lowest corner over the plate
    const Pose X_WT{{0, 0, 0.01 - lowest + height}, askew};
    const ContactSet& set = detector.at(X_WT);
    CAPTURE(height);
    if (height > kReach + 1e-9) {
      CHECK(set.contacts.size() == 0);
      continue;
    }
    if (height > kReach - 1e-9) continue;
    REQUIRE(set.contacts.size() >= 1);
    was_reported = true;
    double deepest = -1;
    for (uint32_t k = 0; k < set.contacts.size(); ++k) {
      deepest = std::max(deepest, depth_of(set.contacts[k], X_WT));
      CHECK(set.contacts[k].normal_O.z == Approx(1));
    }
    CHECK(deepest == Approx(-height).margin(1e-9));
    CHECK((set.n_active > 0) == (height < 0));
  }
  CHECK(was_reported);
}

TEST_CASE("pieces: what moves with the object does not change what the tool feels") {
  const Pose moved{{0.3, -0.2, 0.1}, from_rotation_vector({1, -0.7, 0.4})};
  Detector here(bumps()), there(bumps());
  for (int i = 0; i < 20; ++i) {
    const Pose X_OT = sliding(0.01 * i);
    const Wrench F = piece_wrench(here.at(X_OT), X_OT);
    const Wrench G = piece_wrench(there.at(moved * X_OT, moved), moved * X_OT, moved);
    CHECK(norm(F.f) > 0);
    CHECK_THAT(rotate(conjugate(moved.q), G.f), IsNear(F.f, 1e-3 * norm(F.f)));
  }
}

TEST_CASE("pieces: with the threshold 0 levels of detail are the exact query") {
  Detector exact(bumps());
  Detector levels(bumps(), 0);
  levels.refine.budget = 100'000;
  for (int i = 0; i < 30; ++i) {
    const Pose X_WT = sliding(0.02 * i);
    const Wrench F = piece_wrench(exact.at(X_WT), X_WT), G = piece_wrench(levels.at(X_WT), X_WT);
    CHECK(norm(F.f) > 0);
    CHECK(F.f == G.f);
    CHECK(F.t == G.t);
  }
}

TEST_CASE("pieces: the mean error of the force falls as the threshold falls") {
  constexpr int kPoses = 60;
  std::vector<Vec3> exact;
  Detector leaves(bumps());
  for (int i = 0; i < kPoses; ++i) {
    exact.push_back(piece_wrench(leaves.at(sliding(0.1 * i)), sliding(0.1 * i)).f);
  }
  double before = 0;
  uint64_t work_before = std::numeric_limits<uint64_t>::max();
  const auto thresholds = GENERATE(
      values<std::vector<double>>({{10e-6, 50e-6, 200e-6, 800e-6}, {20e-6, 80e-6, 320e-6}}));
  for (const double threshold : thresholds) {
    Detector levels(bumps(), threshold);
    double error = 0;
    uint64_t work = 0;
    for (int i = 0; i < kPoses; ++i) {
      const Pose X_WT = sliding(0.1 * i);
      error += norm(piece_wrench(levels.at(X_WT), X_WT).f - exact[static_cast<size_t>(i)]) / kPoses;
      work += levels.state.tested;
    }
    CAPTURE(threshold, error, before, work);
    CHECK(error >= before);
    // where the coarsest level is reached neither falls any more
    CHECK((work < work_before || (error == before && work == work_before)));
    before = error;
    work_before = work;
  }
  CHECK(before > 0);
}

TEST_CASE("pieces: the budget of a step is overrun by at most one pair, and what is left is said") {
  for (const uint32_t budget : {0u, 1u, 2u, 5u, 7u, 40u, 60u, 300u}) {
    Detector levels(bumps(), 1e-6);
    levels.refine.budget = budget;
    size_t cut = 0;
    for (int i = 0; i < 30; ++i) {
      const ContactSet& set = levels.at(sliding(0.05 * i));
      CHECK(levels.state.tested <= budget + 1);
      cut += (set.flags & kContactIterationLimit) != 0;
    }
    CAPTURE(budget, cut);
    CHECK(cut > 0);
  }
}

TEST_CASE("pieces: a tool swallowed whole is not pushed: no triangles meet") {
  const Pair small(make_box({0.1, 0.1, 0.02}), make_box({0.002, 0.002, 0.002}), 1e-3);
  Detector detector(small);
  CHECK(detector.at({{0.003, 0.001, 0.005}, {}}).n_active == 0);
  // its upper half is out again
  CHECK(piece_wrench(detector.at({{0.003, 0.001, 0.01}, {}}), {{0.003, 0.001, 0.01}, {}}).f.z > 0);
}

}  // namespace haptic
