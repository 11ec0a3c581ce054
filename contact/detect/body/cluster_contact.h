// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/detect/body/cluster_pushes.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The contact for a cluster of pushes, given in the frame of its object: normal of the cluster,
/// extent 0 (unbounded) and curvature 0, which the caller knows how to find.
Contact contact_of(const PushCluster& cluster_O, uint32_t object, const Pose& X_WO,
                   const Pose& X_WT);

}  // namespace haptic
