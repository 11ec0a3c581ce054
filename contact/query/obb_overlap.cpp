// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/obb_overlap.h"

#include <cmath>

namespace haptic {
namespace {

// axes in floats are orthonormal to 1e-6; each of the tests below adds a few such errors
constexpr double kAxisSlack = 1e-5;
constexpr double kRounding = 1e-14;  // of coordinates in double, moved

double size_of(const CompactObb& box) {
  return static_cast<double>(box.half[0]) + static_cast<double>(box.half[1]) +
         static_cast<double>(box.half[2]);
}

/// Sum of the components: a bound of the norm that takes no root.
double sum_of(const Vec3& v) {
  return std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z);
}

/// Leaves the times s at which |place + s speed| ≤ reach; true where none is left. Written so that
/// what is not a number takes nothing away.
bool narrow(ObbWindow& window, double place, double speed, double reach) {
  // most that are apart are so all the way
  if (std::fabs(place) - reach > std::fabs(speed)) return window.enter = 2, true;
  if (speed == 0) return false;
  const double middle = -place / speed, half = reach / std::fabs(speed);
  if (middle - half > window.enter) window.enter = middle - half;
  if (middle + half < window.leave) window.leave = middle + half;
  return window.is_empty();
}

}  // namespace

ObbSweep at_rest(const Pose& X_AB) {
  return {to_matrix(X_AB.q), X_AB.p, X_AB.p, {}, {}, 0};
}

ObbSweep sweep_between(const RigidMotion& motion, double from, double to) {
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  const Pose X_OT = motion.at(middle);
  return {to_matrix(X_OT.q),
          X_OT.p,
          motion.centre_O + middle * motion.way_O,
          half * motion.way_O,
          half * motion.turn_O,
          half * motion.angle};
}

ObbWindow when_boxes_may_meet(const CompactObb& a, const CompactObb& b, const ObbSweep& sweep) {
  const Obb box_a = a.unpacked(), box_b = b.unpacked();
  const Vec3 centre = sweep.p_AB + sweep.R_AB * box_b.centre_O;
  const Vec3 lever = centre - sweep.centre_A;
  const Vec3 t = box_a.R_BO * (centre - box_a.centre_O);
  const Vec3 d = box_a.R_BO * (sweep.way_A + cross(sweep.turn_A, lever));
  // R[i][j]: axis j of b along axis i of a
  Vec3 R[3];
  for (int j = 0; j < 3; ++j) {
    const Vec3 column = box_a.R_BO * (sweep.R_AB * box_b.R_BO.row[j]);
    R[0][j] = column.x, R[1][j] = column.y, R[2][j] = column.z;
  }
  const Vec3 &h = box_a.half, &g = box_b.half;
  const double bent = sweep.angle * (norm(g) + 0.5 * sweep.angle * (sum_of(lever) + sum_of(g)));
  const double pad =
      bent + kAxisSlack * (size_of(a) + size_of(b) + sum_of(d)) +
      kRounding * (sum_of(sweep.p_AB) + sum_of(box_a.centre_O) + sum_of(box_b.centre_O));
  ObbWindow window;
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
  if (b.count > 0 || (a.count == 0 && size_of(a.box) >= size_of(b.box))) {
    return {NodePair{a.first, pair.b}, NodePair{a.first + 1U, pair.b}};
  }
  return {NodePair{pair.a, b.first}, NodePair{pair.a, b.first + 1U}};
}

}  // namespace haptic
