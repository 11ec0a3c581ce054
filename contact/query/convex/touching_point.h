// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/convex/gauss_overlay.h"

namespace haptic {

/// The place on a, in A, where the features of an overlay vertex would touch after b has moved by
/// depth · n. Of edges or faces that touch along more than a point, the middle of it.
Vec3 touching_point(const HullPair& pair, const OverlayVertex& at);

}  // namespace haptic
