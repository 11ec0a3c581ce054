// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/box/obb_overlap.h"

#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

// relative: float axes are orthonormal to 1e-6, and each test adds a few such errors
constexpr double kAxisSlack = 1e-5;
constexpr double kMovedRounding = 1e-14;  // relative, of moved coordinates in double
constexpr double kMuchTurn = 0.05;  // [rad] per half sweep, above which spheres are tested first

double size_of(const CompactObb& box) {
  return static_cast<double>(box.half[0]) + static_cast<double>(box.half[1]) +
         static_cast<double>(box.half[2]);
}

/// 1-norm: a bound of the norm without a square root.
double sum_of(const Vec3& v) {
  return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z);
}

/// Written so that not-a-number removes nothing.
void keep_within(SweepWindow& window, double middle, double half) {
  if (middle - half > window.enter) window.enter = middle - half;
  if (middle + half < window.leave) window.leave = middle + half;
}

/// Intersects the window with the times s at which |place + s speed| ≤ reach; true if nothing is
/// left. Not-a-number removes nothing.
bool narrow(SweepWindow& window, double place, double speed, double reach) {
  // most pairs that are apart are so for the whole sweep
  if (std::fabs(place) - reach > std::fabs(speed)) return window.enter = 2, true;
  if (speed == 0) return false;
  const double middle = -place / speed, half = reach / std::fabs(speed);
  keep_within(window, middle, half);
  return window.is_empty();
}

/// Two boxes in the middle of the sweep, in A.
struct Halfway {
  Obb box_a, box_b;
  Vec3 apart, lever;  // from a's centre, and from the centre of rotation, to b's centre
  Vec3 way;           // of b's centre until the end, to first order
  double rounding;    // [m]
};

Halfway halfway(const CompactObb& a, const CompactObb& b, const ObbSweep& sweep) {
  Halfway at{a.unpacked(), b.unpacked(), {}, {}, {}, 0};
  const Vec3 centre_b = sweep.p_AB + sweep.R_AB * at.box_b.centre_O;
  at.apart = centre_b - at.box_a.centre_O;
  at.lever = centre_b - sweep.centre_A;
  at.way = sweep.way_A + cross(sweep.turn_A, at.lever);
  at.rounding =
      kAxisSlack * (size_of(a) + size_of(b) + sum_of(at.way)) +
      kMovedRounding * (sum_of(sweep.p_AB) + sum_of(at.box_a.centre_O) + sum_of(at.box_b.centre_O));
  return at;
}

/// The times s at which |apart + s way| is at most the sum of the radii. Handles not-a-number as
/// narrow does.
SweepWindow window_of_spheres(const Halfway& at, double angle) {
  const double bent = 0.5 * angle * angle * norm(at.lever);
  const double reach = norm(at.box_a.half) + norm(at.box_b.half) + bent + at.rounding;
  const double apart = norm(at.apart), way2 = norm_squared(at.way), way = std::sqrt(way2);
  constexpr SweepWindow kNever{2, -2};
  if (apart - reach > way) return kNever;
  // within reach during the whole sweep
  if (!(apart + way > reach)) return {};
  const double rest2 = reach * reach - norm_squared(cross(at.apart, at.way)) / way2;
  if (rest2 < 0) return kNever;
  const double middle = -dot(at.apart, at.way) / way2, half = std::sqrt(rest2) / way;
  SweepWindow window;
  keep_within(window, middle, half);
  return window;
}

}  // namespace

ObbSweep at_rest(const Pose& X_AB) {
  return {to_matrix(X_AB.q), X_AB.p, X_AB.p, {}, {}, 0};
}

ObbSweep sweep_between(const RigidMotion& motion, double from, double to) {
  HAPTIC_ASSERT(from <= to);
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  const Pose X_OT = motion.at(middle);
  return {to_matrix(X_OT.q),
          X_OT.p,
          motion.centre_O + middle * motion.way_O,
          half * motion.way_O,
          half * motion.turn_O,
          half * motion.angle};
}

SweepWindow when_spheres_may_meet(const CompactObb& a, const CompactObb& b, const ObbSweep& sweep) {
  return window_of_spheres(halfway(a, b, sweep), sweep.angle);
}

SweepWindow when_boxes_may_meet(const CompactObb& a, const CompactObb& b, const ObbSweep& sweep) {
  const Halfway at = halfway(a, b, sweep);
  // rotation enlarges the boxes' projections but not the spheres': the sphere test is worth its
  // cost only where b rotates much
  SweepWindow window;
  if (sweep.angle > kMuchTurn) window = window_of_spheres(at, sweep.angle);
  if (window.is_empty()) return window;
  const Obb &box_a = at.box_a, &box_b = at.box_b;
  const Vec3 t = box_a.R_BO * at.apart, d = box_a.R_BO * at.way;
  // R[i][j]: axis j of b along axis i of a
  Vec3 R[3];
  for (int j = 0; j < 3; ++j) {
    const Vec3 column = box_a.R_BO * (sweep.R_AB * box_b.R_BO.row[j]);
    R[0][j] = column.x, R[1][j] = column.y, R[2][j] = column.z;
  }
  const Vec3 &h = box_a.half, &g = box_b.half;
  const double bent = sweep.angle * (norm(g) + 0.5 * sweep.angle * (sum_of(at.lever) + sum_of(g)));
  const double pad = bent + at.rounding;
  for (int i = 0; i < 3; ++i) {
    const Vec3& row = R[i];
    const double reach_b = g.x * std::fabs(row.x) + g.y * std::fabs(row.y) + g.z * std::fabs(row.z);
    if (narrow(window, t[i], d[i], h[i] + reach_b + pad)) return window;
  }
  for (int j = 0; j < 3; ++j) {
    const Vec3 column{R[0][j], R[1][j], R[2][j]};
    const double reach_a =
        h.x * std::fabs(column.x) + h.y * std::fabs(column.y) + h.z * std::fabs(column.z);
    if (narrow(window, dot(t, column), dot(d, column), reach_a + g[j] + pad)) return window;
  }
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double reach = h[i1] * std::fabs(R[i2][j]) + h[i2] * std::fabs(R[i1][j]) +
                           g[j1] * std::fabs(R[i][j2]) + g[j2] * std::fabs(R[i][j1]);
      if (narrow(window, t[i2] * R[i1][j] - t[i1] * R[i2][j], d[i2] * R[i1][j] - d[i1] * R[i2][j],
                 reach + pad)) {
        return window;
      }
    }
  }
  return window;
}

std::array<NodePair, 2> opened(const NodePair& pair, const ObbTree& tree_A, const ObbTree& tree_B) {
  const ObbNode &a = tree_A.nodes[pair.a], &b = tree_B.nodes[pair.b];
  HAPTIC_ASSERT(a.count == 0 || b.count == 0);
  if (b.count > 0 || (a.count == 0 && size_of(a.box) >= size_of(b.box))) {
    return {NodePair{a.first, pair.b}, NodePair{a.first + 1U, pair.b}};
  }
  return {NodePair{pair.a, b.first}, NodePair{pair.a, b.first + 1U}};
}

}  // namespace haptic
