// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/point/point_proxy.h"

namespace haptic {

/// The shading normal over the true one, at most 45° from it, unit.
Vec3 limited_normal(const Vec3& shading, const Vec3& normal);

/// Force shading in two passes (Ruspini, Kolarov, Khatib 1997): the tool is projected onto the
/// planes as the shading normals m_i turn them, then what came out onto the true planes. Returns
/// that place of the proxy: with one plane the force points along m exactly. Deviation: the turned
/// plane goes through the point of the true one that lies along m from the tool, which is where the
/// paper's iteration over ticks ends. Normals that lean by more than 45° are brought back to 45°.
/// Shaded contacts are slightly active: the work around a loop is not zero.
/// normals_W: one for each push of the solution.
Vec3 shaded_proxy(const PointProxySolution& solution, const PlanesInForce& planes,
                  const Vec3& tool_W, const std::array<Vec3, 3>& normals_W);

}  // namespace haptic
