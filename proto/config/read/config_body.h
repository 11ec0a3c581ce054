// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/config/read/config_section.h"
#include "proto/config/session_config.h"

namespace haptic {

/// Reads [object.body]: what the object weighs, and how it bounces. Throws ConfigError.
void read_body(Section& object, const ObjectConfig& about, BodyConfig& body);

/// Reads [sim], which depends on whether any object has mass. Throws ConfigError.
void read_sim(Section& root, SessionConfig& config);

/// Triangle inequality: no moment exceeds the sum of the two others (equal for a thin plate).
/// Throws ConfigError at `inertia`.
void check_inertia(const Section& section, const Vec3& inertia);

}  // namespace haptic
