// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/render.h"

/// The solvers of a point: planes at this tick, a proxy, the coupling's force.
namespace haptic {

/// The contacts at this tick, for a point at the tool's origin.
ProxyQuestion point_question(const RenderQuestion& question);

/// The coupling's force between the tool and that proxy, and what it pushes the objects with.
Rendered rendered_point(const RenderQuestion& question, const PointProxySolution& proxy);

struct PointProxySolver {
  Rendered render(const ServoModel& model, const RenderQuestion& question, ContactSolvers& solvers);
};

struct DirectSolver {
  Rendered render(const ServoModel& model, const RenderQuestion& question, ContactSolvers& solvers);
};

struct VirtualProxySolver {
  Rendered render(const ServoModel& model, const RenderQuestion& question, ContactSolvers& solvers);

  VirtualProxyState state;
};

}  // namespace haptic
