// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/config/read/config_section.h"
#include "proto/config/session_config.h"

namespace haptic {

/// Reads [object.body]: what the object weighs, and how it bounces. Throws ConfigError.
void read_body(Section& object, const ObjectConfig& about, BodyConfig& body);

/// Reads [sim], which depends on whether any object has mass. Throws ConfigError.
void read_sim(Section& root, SessionConfig& config);

/// The mass and inertia of a body, where their keys go.
struct MassKeys {
  double& density;
  double& mass;
  Vec3& inertia;
};

/// Reads `density`, or `mass` in this range [kg] and `inertia`. Throws ConfigError, also where the
/// moments break the triangle inequality: none exceeds the sum of the two others (equal for a thin
/// plate).
void read_mass(Section& section, const Range& masses, const MassKeys& keys);

}  // namespace haptic
