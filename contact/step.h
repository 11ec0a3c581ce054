// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "contact/detect/near_features.h"
#include "contact/detect/point_proxy.h"
#include "proto/config.h"
#include "proto/wire.h"

namespace haptic {

/// All that is constant after start.
struct ContactModel {
  std::array<MeshShape, kMaxObjects> shapes;
  uint32_t n_objects = 0;
  std::array<Pose, kMaxObjects> X_WO;               // configured poses, until a SceneFrame arrives
  double epsilon = 1e-7;                            // stand-off of the verified proxy [m]
  double radius = 0;                                // of the proxy of virtual-proxy3 [m]
  std::array<double, kMaxObjects> crease_cosine{};  // smoother edges are shaded; 1: none
  double servo_period = 1e-3;                       // [s]
  double prediction = 1e-3;  // from the question to the tick that uses the answer [s]
};

/// All that survives a step.
struct ContactState {
  PointProxy proxy;
  Renderer renderer = Renderer::kGodObject3;  // whose detector answered last
  uint64_t seq = 0;
  uint64_t reseeds = 0;
  int64_t last_answered_ns = 0;
  double period = 1e-3;  // smoothed time between answered frames [s]
  NearScratch scratch;
  std::array<NearFeature, kMaxContacts> features;
};

/// Shapes in the order of the config's objects; they must outlive the model.
ContactModel build_contact_model(const SessionConfig& config, std::span<const MeshShape> shapes);

/// Answers one ServoFrame with the detector of its renderer. The hard ones move the verified proxy
/// towards the tool, less what friction holds back. The answer is used one tick later, so the
/// facets reported are those that carry a proxy sent on to where the tool will then be (tool and
/// objects on their way as they move now), then the features it may reach before the next two
/// answers, within v·(2·T_contact + T). A slide that was cut short is held where it ended, by one
/// plane across the way to the tool. penalty3 reports the nearest surface of each object, and keeps
/// nothing. A restarted contact takes the proxy up where the servo last saw it. `scene` may be
/// null. Allocates nothing.
ContactSet contact_step(const ContactModel& model, ContactState& state, const ServoFrame& servo,
                        const SceneFrame* scene);

}  // namespace haptic
