// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <functional>

#include "servo/solve/body/soft_contact.h"
#include "servo/solve/coupled_body.h"
#include "tests/support/meshes.h"

namespace haptic::test {

/// Largest relative difference between the analytic Jacobians of a wrench and central differences.
inline double jacobian_error(const std::function<BodyWrench(const BodyMotion&)>& wrench_of,
                             const BodyMotion& at, double length, double speed) {
  const BodyWrench here = wrench_of(at);
  double error = 0;
  const auto unit = [](size_t i, double size) {
    std::array<double, 6> e{};
    e[i] = size;
    return Twist{{e[0], e[1], e[2]}, {e[3], e[4], e[5]}};
  };
  const auto compare = [&](const Mat6& analytic, size_t column, const BodyWrench& plus,
                           const BodyWrench& minus, double step) {
    double scale = 0;
    for (const double a : analytic.a) scale = std::max(scale, std::fabs(a));
    const auto up = components(plus.F_W.f, plus.F_W.t), down = components(minus.F_W.f, minus.F_W.t);
    for (size_t row = 0; row < 6; ++row) {
      const double difference = (up[row] - down[row]) / (2 * step);
      error = std::max(error, std::fabs(difference - analytic(row, column)) / scale);
    }
  };
  for (size_t i = 0; i < 6; ++i) {
    const Twist dq = unit(i, length), back = unit(i, -length);
    compare(here.by_motion, i, wrench_of({moved(at.X_WC, dq), at.V_WC}),
            wrench_of({moved(at.X_WC, back), at.V_WC}), length);
    const Twist du = unit(i, speed);
    const auto faster = [&](double sign) {
      return BodyMotion{at.X_WC, {at.V_WC.v + sign * du.v, at.V_WC.w + sign * du.w}};
    };
    compare(here.by_twist, i, wrench_of(faster(1)), wrench_of(faster(-1)), speed);
  }
  return error;
}

/// A flat contact that is felt whole, with an object at rest.
inline SoftContact spring_contact(const Vec3& tool_point_C, const Vec3& point_W,
                                  const Vec3& normal_W, double stiffness) {
  SoftContact c;
  c.tool_point_C = tool_point_C;
  c.point_W = point_W;
  c.normal_W = normal_W;
  c.stiffness = stiffness;
  return c;
}

/// A contact pressed in by up to 1 mm, somewhere on a tool of 5 cm.
inline SoftContact random_contact(Random& random, const Pose& X_WC) {
  SoftContact c;
  c.tool_point_C = 0.05 * random.direction();
  c.normal_W = random.direction();
  c.point_W = X_WC * c.tool_point_C + random.uniform(1e-4, 1e-3) * c.normal_W;
  c.stiffness = random.uniform(100, 5000);
  c.damping = random.uniform(0, 0.05);
  return c;
}

inline Twist random_twist(Random& random, double speed, double spin) {
  return {speed * random.direction(), spin * random.direction()};
}

}  // namespace haptic::test
