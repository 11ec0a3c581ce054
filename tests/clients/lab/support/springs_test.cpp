// SPDX-License-Identifier: GPL-3.0-or-later
// The stiffness of the coupling is changed while a rigid tool is pressed on a block: contact and
// servo look for its pose in the metric of the springs that are in force.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <vector>

#include "clients/lab/support/scripted_hand.h"
#include "clients/lockstep/lockstep.h"
#include "contact/bake/session.h"
#include "proto/wire/renderer.h"
#include "tests/support/least_squares.h"
#include "tests/support/over_block.h"

namespace haptic {
namespace {

constexpr double kTilt = 0.15;    // of the hand, about y [rad]
constexpr double kHandZ = 0.007;  // of the hand above the block [m]
constexpr double kMargin = 1e-8;  // kept to every surface [m]
// a tenth of what a change of ten times asks for within the ramp's 200 ms
constexpr double kSlew = 10, kTorqueSlew = 0.1;  // [N/s], [N·m/s]

struct Springs {
  double translational, rotational;  // [N/m], [N·m/rad]
};

/// K times a motion.
Wrench operator*(const Springs& k, const Twist& a) {
  return {k.translational * a.v, k.rotational * a.w};
}

/// √(Fᵀ K⁻¹ F), over √k_T a force [N].
double size_of(const Springs& k, const Wrench& F) {
  return std::sqrt(norm_squared(F.f) + k.translational / k.rotational * norm_squared(F.t));
}

/// The row of a contact: its push per newton, about the tool's origin at X_WG, and its gap.
struct Row {
  Wrench push;
  double gap;  // after a motion from X_WG [m]
};

/// The rows of a set as contact has published it, after a motion from its X_WG.
std::vector<Row> rows_of(const ContactSet& set, const Twist& a) {
  std::vector<Row> rows;
  for (const Contact& c : set.contacts) {
    const Pose& X_WO = set.objects[c.object].X_WO;
    const Vec3 normal = rotate(X_WO.q, c.normal_O), lever = rotate(set.X_WG.q, c.tool_point_T);
    const Vec3 point = set.X_WG.p + lever + a.v + cross(a.w, lever);
    rows.push_back({{normal, cross(lever, normal)}, dot(normal, point - X_WO * c.object_point_O)});
  }
  return rows;
}

/// F − Σ λ J for the pushes λ that make it least, by complete orthogonal decomposition; none where
/// one of them would pull.
std::optional<Wrench> rest_of(const Springs& k, const Wrench& F, const std::vector<Row>& rows) {
  const double scale = std::sqrt(k.translational / k.rotational);
  const auto column = [scale](const Wrench& G) {
    Eigen::VectorXd out(6);
    out << G.f.x, G.f.y, G.f.z, scale * G.t.x, scale * G.t.y, scale * G.t.z;
    return out;
  };
  Eigen::MatrixXd J(6, static_cast<Eigen::Index>(rows.size()));
  for (size_t i = 0; i < rows.size(); ++i) {
    J.col(static_cast<Eigen::Index>(i)) = column(rows[i].push);
  }
  const Eigen::VectorXd pushes = test::shortest_solution(J, column(F));
  Wrench rest = F;
  for (size_t i = 0; i < rows.size(); ++i) {
    const double push = pushes[static_cast<Eigen::Index>(i)];
    if (push < 0) return std::nullopt;
    rest = rest + -push * rows[i].push;
  }
  return rest;
}

/// The distance of the force F of the springs from all that the rows can push with, in K⁻¹ [N]: the
/// least over all sets of them.
double out_of_cone(const Springs& k, const Wrench& F, const std::vector<Row>& rows) {
  REQUIRE(rows.size() < 10);
  double least = size_of(k, F);
  for (size_t set = 1; set < size_t{1} << rows.size(); ++set) {
    std::vector<Row> chosen;
    for (size_t i = 0; i < rows.size(); ++i) {
      if ((set >> i & 1) != 0) chosen.push_back(rows[i]);
    }
    if (const auto rest = rest_of(k, F, chosen)) least = std::min(least, size_of(k, *rest));
  }
  return least;
}

/// The residual of the KKT conditions at the motion a from X_WG, with the hand at a_u.
struct Residual {
  double stationarity;  // |K (a − a_u) − Σ λ J| over |K (a − a_u)|, both in K⁻¹
  double overlap;       // of the worst row [m]
};

/// Rows push that are no farther than `touching` [m].
Residual residual_of(const Springs& k, const Twist& a, const Twist& hand, const ContactSet& set,
                     double touching) {
  std::vector<Row> rows = rows_of(set, a);
  double overlap = 0;
  for (const Row& row : rows) overlap = std::max(overlap, -row.gap);
  std::erase_if(rows, [touching](const Row& row) { return row.gap > touching; });
  const Wrench F = k * (a - hand);
  return {out_of_cone(k, F, rows) / size_of(k, F), overlap};
}

/// The growth of a wrench from the one before: its distance from every smaller share of that.
double growth(const Vec3& before, const Vec3& now) {
  const double along = norm_squared(before) > 0 ? dot(now, before) / norm_squared(before) : 0;
  return norm(now - std::clamp(along, 0.0, 1.0) * before);
}

/// A hand that holds still, tilted and inside the block, after it came from above.
Pose pressing(double t) {
  constexpr double kDown = 0.2;  // [s]
  const double above = t < kDown ? 0.02 * (1 - t / kDown) : 0;
  return {{0, 0, kHandZ + above}, from_rotation_vector({0, kTilt, 0})};
}

SessionConfig cube_over_block(Renderer renderer, const Springs& springs) {
  SessionConfig config = test::over_block(renderer, test::kCube);
  config.coupling.translational_stiffness = springs.translational;
  config.coupling.rotational_stiffness = springs.rotational;
  config.rigid.margin = kMargin;
  config.safety.soft_start = 0;
  config.safety.max_force = 1e3;
  config.safety.max_torque = 1e2;
  config.safety.slew = kSlew;
  config.safety.torque_slew = kTorqueSlew;
  return config;
}

}  // namespace

TEST_CASE("springs: a stiffness that changes in mid-contact reaches contact too", "[lab]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  const Springs before{500, 0.5};
  const Springs after = GENERATE(Springs{5000, 0.5}, Springs{500, 5}, Springs{5000, 5});
  const SessionConfig config = cube_over_block(renderer, before);
  const BakedSession baked = bake_session(config);
  ScriptedHand hand(std::function<Pose(double)>(pressing), 1e2);
  Lockstep lockstep(config, baked.shapes(), hand);
  CAPTURE(row_of(renderer).name, after.translational, after.rotational);
  Wrench held_B;
  double growth_of_force = 0, growth_of_torque = 0;
  const auto settle = [&](int ticks) {
    growth_of_force = growth_of_torque = 0;
    for (int k = 0; k < ticks; ++k) {
      REQUIRE(lockstep.step());
      growth_of_force = std::max(growth_of_force, growth(held_B.f, hand.held.f));
      growth_of_torque = std::max(growth_of_torque, growth(held_B.t, hand.held.t));
      held_B = hand.held;
    }
  };
  const auto check = [&](const Springs& springs) {
    REQUIRE(lockstep.contacts() != nullptr);
    const ContactSet& set = *lockstep.contacts();
    const ServoFrame& f = lockstep.frame();
    const Twist to_hand = way_between(set.X_WG, f.X_WT), to_proxy = way_between(set.X_WG, f.X_WP);
    const Residual servo = residual_of(springs, to_proxy, to_hand, set, 1e-12);
    CHECK(servo.stationarity < 1e-9);
    CHECK(servo.overlap < 1e-12);
    const Wrench wanted = springs * (to_proxy - to_hand);
    CHECK(size_of(springs, f.F_coupling_W + -wanted) < 1e-9 * size_of(springs, wanted));
    const Residual contact = residual_of(springs, {}, to_hand, set, 0.1 * kMargin);
    CHECK(contact.stationarity < 1e-9);
    CHECK(contact.overlap < 1e-12);
  };
  settle(2500);
  check(before);
  lockstep.control().translational_stiffness = after.translational;
  lockstep.control().rotational_stiffness = after.rotational;
  ++lockstep.control().revision;
  settle(2500);
  check(after);
  CHECK(growth_of_force <= (1 + 1e-9) * kSlew / config.servo_rate);
  CHECK(growth_of_torque <= (1 + 1e-9) * kTorqueSlew / config.servo_rate);
  // where the limit is less than what the ramp asks for
  const bool is_slewed = after.translational > before.translational;
  CHECK(growth_of_force > (is_slewed ? 0.9 * kSlew / config.servo_rate : 0));
}

}  // namespace haptic
