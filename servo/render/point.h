// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/render.h"

namespace haptic {

/// The contacts at this tick, for a point at the tool's origin.
ProxyQuestion point_question(const RenderQuestion& question);

/// The coupling's force between the tool and that proxy, and what it pushes the objects with.
Rendered rendered_point(const RenderQuestion& question, const PointProxySolution& proxy);

}  // namespace haptic
