// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <concepts>
#include <optional>
#include <span>
#include <vector>

#include "contact/detect/body_detectors.h"
#include "contact/detect/near_features.h"
#include "contact/detect/point_proxy.h"
#include "contact/detect/rigid_tool.h"
#include "proto/config/config.h"
#include "proto/wire/wire.h"

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
  BodyModel bodies;
  GodObject6Options rigid;
  bool has_friction = false;  // of any object
};

/// All that survives a step. Without a model it has no room for tools with six degrees of freedom.
struct ContactState {
  ContactState() = default;
  explicit ContactState(const ContactModel& model);

  PointProxy proxy;
  Renderer renderer = Renderer::kGodObject3;  // whose detector answered last
  uint64_t seq = 0;
  uint64_t reseeds = 0;
  int64_t last_answered_ns = 0;
  double period = 1e-3;  // smoothed time between answered frames [s]
  NearScratch scratch;
  std::array<NearFeature, kMaxContacts> features;
  BodyState bodies;
  std::optional<RigidTool> rigid;
};

ContactModel build_contact_model(const SessionConfig& config, const ContactShapes& shapes);

/// Answers one ServoFrame with the detector of its renderer. The hard ones move the verified proxy
/// towards the tool, less what friction holds back. The answer is used one tick later, so the
/// facets reported are those that carry a proxy sent on to where the tool will then be (tool and
/// objects on their way as they move now), then the features it may reach before the next two
/// answers, within v·(2·T_contact + T). A slide that was cut short is held where it ended, by one
/// plane across the way to the tool. penalty3 reports the nearest surface of each object, and keeps
/// nothing. Tools with six degrees of freedom are asked about where the servo has their proxy, and
/// what may touch before the next two answers is reported too; the rigid renderers keep a verified
/// pose of them here (rigid_tool.h). A restarted contact takes the proxy up where the servo last
/// saw it. `scene` may be null. Allocates nothing, but for what a rigid tool remembers of the
/// surfaces near it, which grows until it has held the most.
ContactSet contact_step(const ContactModel& model, ContactState& state, const ServoFrame& servo,
                        const SceneFrame* scene);

}  // namespace haptic
