// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/point/point_proxy.h"

namespace haptic {

/// The shading normal, turned to within 45° of the true one, unit.
Vec3 limited_normal(const Vec3& shading, const Vec3& normal);

/// Force shading in two passes (Ruspini, Kolarov, Khatib 1997): the tool is projected onto the
/// planes turned to the shading normals m_i, and the result onto the true planes. Returns that
/// place of the proxy: with one plane the force points along m exactly. Deviation: the turned plane
/// passes through the point of the true plane that lies along m from the tool, which is the limit
/// of the paper's iteration over ticks. Normals more than 45° off are limited to 45°. Shading is
/// slightly active: the work around a closed loop is not zero. normals_W: one for each push of the
/// solution.
Vec3 shaded_proxy(const PointProxySolution& solution, const PlanesInForce& planes,
                  const Vec3& tool_W, const std::array<Vec3, 3>& normals_W);

}  // namespace haptic
