// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/joint/joint.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "proto/math/assert.h"
#include "proto/math/mat3.h"

namespace haptic {
namespace {

// ω² dt² of a spring on its mass: a stiffer one is integrated implicitly, which damps it; without
// that, beyond 4 it would explode
constexpr double kStiff = 0.25;

/// Turns z to a unit vector.
Quat from_z_to(const Vec3& axis) {
  const Vec3 x = any_perpendicular(axis);
  const Vec3 turn = cross({0, 0, 1}, axis);
  const double angle = std::atan2(norm(turn), axis.z);
  if (norm(turn) > 0) return from_rotation_vector(angle * normalized(turn));
  return axis.z > 0 ? Quat{} : from_rotation_vector(std::numbers::pi * x);
}

/// Speed along a direction of B, of the point p_W of A.
JointRow along_row(const Vec3& d_W, const Vec3& p_W, const Vec3& centre_a, const Vec3& centre_b) {
  return {{d_W, cross(p_W - centre_a, d_W)}, {-d_W, -cross(p_W - centre_b, d_W)}};
}
JointRow about_row(const Vec3& d_W) {
  return {{{}, d_W}, {{}, -d_W}};
}

/// The angle about z of a rotation, near another one.
double twist_about_z(const Quat& q, double near) {
  const double angle = 2 * std::atan2(q.z, q.w);
  const double turn = 2 * std::numbers::pi;
  return angle + turn * std::round((near - angle) / turn);
}

JointAxis straight_axis(const Joint&, const Pose& A, const Pose& B, double) {
  const std::array<Vec3, 3> axes_W{rotate(B.q, {1, 0, 0}), rotate(B.q, {0, 1, 0}),
                                   rotate(B.q, {0, 0, 1})};
  return {axes_W, B.p, {}, dot(axes_W[2], A.p - B.p)};
}

CurvePoint straight_point(const Joint&, double position) {
  return {{0, 0, position}, {0, 0, 1}, {}};
}

JointAxis curved_axis(const Joint& joint, const Pose& A, const Pose& B, double near) {
  const double position = nearest_length(joint.curve, inverse(B) * A.p, near);
  const CurvePoint at = curve_at(joint.curve, position);
  const Vec3 tangent_W = rotate(B.q, at.tangent), across_W = any_perpendicular(tangent_W);
  return {{across_W, cross(tangent_W, across_W), tangent_W},
          B * at.p,
          rotate(B.q, at.curvature),
          position};
}

CurvePoint curved_point(const Joint& joint, double position) {
  return curve_at(joint.curve, position);
}

}  // namespace

extern const JointPath straight_path{straight_axis, straight_point};
extern const JointPath curved_path{curved_axis, curved_point};
#define JOINT(kind, name, path, ...) extern const JointPath path;
#include "proto/config/joints.def"

namespace {

const JointPath& path_of(const Joint& joint) {
  static constexpr std::array<const JointPath*, kJointKinds.size()> kPaths{
#define JOINT(kind, name, path, ...) &path,
#include "proto/config/joints.def"
  };
  return *kPaths[static_cast<size_t>(joint.config.kind)];
}

}  // namespace

Joint build_joint(const JointConfig& config, const Pose& X_WA, const Pose& X_WB) {
  Joint joint;
  joint.config = config;
  const bool has_points = row_of(config.kind).has_points;
  const Pose X_WJ{config.at_W, has_points ? Quat{} : from_z_to(config.axis_W)};
  joint.X_AJ = inverse(X_WA) * X_WJ;
  joint.X_BJ = inverse(X_WB) * X_WJ;
  std::vector<double> positions, loads;
  for (uint32_t i = 0; i < config.n_detents; ++i) {
    positions.push_back(config.detents[i].position);
    loads.push_back(config.detents[i].load);
  }
  if (config.n_detents > 0) joint.detents = build_spline(positions, loads);
  if (!has_points) return joint;
  std::vector<Vec3> points{{}};
  for (uint32_t i = 0; i < config.n_points; ++i) {
    points.push_back(inverse(X_WJ) * config.points_W[i]);
  }
  joint.curve = build_curve(points);
  joint.config.lower = std::max(config.lower, 0.0);
  joint.config.upper = std::min(config.upper, joint.curve.length);
  return joint;
}

JointRows joint_rows(const Joint& joint, const Pose& X_WA, const Pose& X_WB, double near) {
  const JointKindRow& kind = row_of(joint.config.kind);
  const Pose A = X_WA * joint.X_AJ, B = X_WB * joint.X_BJ;
  const JointAxis axis = path_of(joint).axis(joint, A, B, near);
  const std::array<Vec3, 3>& axes = axis.axes_W;
  JointRows rows;
  rows.anchor_W = axis.anchor_W;
  rows.axis_W = axes[2];
  rows.curvature_W = axis.curvature_W;
  const auto lock = [&](JointRow row, double error) {
    row.error = error;
    rows.locks[rows.n_locks++] = row;
  };
  const Vec3 off = A.p - axis.anchor_W;
  for (size_t k = 0; k < (kind.slides ? 2u : 3u); ++k) {
    lock(along_row(axes[k], A.p, X_WA.p, X_WB.p), dot(axes[k], off));
  }
  const Vec3 rotation = to_rotation_vector(A.q * conjugate(B.q));
  if (kind.twists) {
    const Vec3 swung = cross(axes[2], rotate(A.q, {0, 0, 1}));
    for (size_t k = 0; k < 2; ++k) lock(about_row(axes[k]), dot(axes[k], swung));
  } else if (!kind.swings) {
    for (const Vec3& each : axes) lock(about_row(each), dot(each, rotation));
  }
  if (kind.turns()) {
    rows.along = about_row(axes[2]);
    rows.position = twist_about_z(conjugate(B.q) * A.q, near);
  } else if (kind.slides) {
    rows.along = along_row(axes[2], A.p, X_WA.p, X_WB.p);
    rows.position = axis.position;
  } else if (kind.swings) {
    rows.position = norm(rotation);
    if (rows.position > 0) rows.along = about_row(rotation / rows.position);
  }
  return rows;
}

Pose pose_on(const Joint& joint, const Pose& X_WB, double position) {
  HAPTIC_ASSERT(row_of(joint.config.kind).is_led());
  Pose X_JJ;
  if (row_of(joint.config.kind).turns()) {
    X_JJ.q = from_rotation_vector({0, 0, position});
  } else {
    X_JJ.p = path_of(joint).at(joint, position).p;
  }
  const Pose X_WA = X_WB * joint.X_BJ * X_JJ * inverse(joint.X_AJ);
  return {X_WA.p, normalized(X_WA.q)};
}

Vec3 direction_on(const Joint& joint, const Pose& X_WB, double position) {
  return rotate(X_WB.q * joint.X_BJ.q, path_of(joint).at(joint, position).tangent);
}

JointLoad load_at(const Joint& joint, double position) {
  const JointConfig& config = joint.config;
  JointLoad load{config.stiffness * (config.rest - position), -config.stiffness};
  if (joint.detents.x.empty()) return load;
  const SplineValue table = spline_at(joint.detents, position);
  load.load += table.y;
  if (position > joint.detents.x.front() && position < joint.detents.x.back()) {
    load.slope += table.first;
  }
  return load;
}

double speed_by_end(const Joint& joint, const CoordinateStep& step, double load) {
  const double dt = step.dt, drag = dt * step.mobility * joint.config.damping;
  const JointLoad now = load_at(joint, step.position);
  // v′ = v + dt w (F + s dt v′ − c (v′ + u)), s of stiff springs only
  const double spring = dt * dt * step.mobility * now.slope;
  return (step.speed + dt * step.mobility * (load + now.load) - drag * step.pushed_speed) /
         (1 + drag - (-spring > kStiff ? spring : 0));
}

}  // namespace haptic
