// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/detect/body/cluster_pushes.h"
#include "proto/wire/wire.h"

namespace haptic {

/// A cluster of pushes on a body, in the frame of its object, as a contact: its own normal, and no
/// bound (extent 0) where nobody knows how far the object goes on.
Contact contact_of(const PushCluster& cluster_O, uint32_t object, const Pose& X_WO,
                   const Pose& X_WT);

}  // namespace haptic
