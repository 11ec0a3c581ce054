// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "contact/detect/body/clear_pose.h"
#include "contact/detect/body/exact.h"
#include "contact/detect/body/god_object6.h"
#include "contact/detect/body/pieces.h"
#include "contact/detect/body/voxel.h"
#include "contact/detect/point/point_proxy.h"
#include "contact/given/given_touch.h"
#include "contact/shape/baked/contact_shapes.h"
#include "proto/config/config.h"
#include "proto/wire/wire.h"

namespace haptic {

/// All that is constant after start. Not copyable: voxel.objects views `volumes`.
struct ContactModel {
  ContactModel() = default;
  ContactModel(ContactModel&&) = default;
  ContactModel& operator=(ContactModel&&) = default;

  bool has_tool() const { return body.mass > 0; }
  bool has_maps() const { return has_tool() && !volumes.empty(); }

  std::vector<MeshShape> shapes;                    // of the objects
  PerObject<Pose> X_WO;                             // configured poses, until a SceneFrame arrives
  double epsilon = 1e-7;                            // stand-off of the verified proxy [m]
  uint32_t hand = kFirstHand;                       // whose tool it is
  uint32_t n_tools = 0;                             // of the shapes, the last: of other hands
  double radius = 0;                                // of the proxy of virtual-proxy3 [m]
  std::array<double, kMaxObjects> crease_cosine{};  // smoother edges are shaded; 1: none
  double servo_period = 1e-3;                       // [s]
  double prediction = 1e-3;  // from the question to the tick that uses the answer [s]
  MeshShape tool;
  ToolBody body{};  // of the tool; mass 0: it is a point
  GodObject6Options rigid;
  PushOptions exact;
  PieceModel pieces;
  std::vector<VoxelObject> volumes;
  VoxelModel voxel;
  ClearanceModel clearance;   // of voxel
  bool has_friction = false;  // of any object
  int32_t grasp_button = -1;  // bit of DeviceState::buttons; −1: nothing is grasped
  Renderer renderer{};        // that the session begins with
  GivenTouchModel given;      // by clients
};

/// The options of the god-object of six degrees of freedom, from a session's config.
GodObject6Options god_object_options(const SessionConfig& config, const ToolBody& body);

ContactModel build_contact_model(const SessionConfig& config, const ContactShapes& shapes);

/// One ServoFrame, as a detector is asked about it.
struct ContactQuestion {
  const ServoFrame& servo;
  const SceneFrame* scene;  // null: none has come
  Renderer renderer;
  const PointScene& now;  // the objects at the frame's tick
  double reach = 0;       // how far ahead is looked [m]
  bool changed = false;   // another renderer was asked before
  bool usable = true;     // every pose is finite; else the place that is known is reported again
};

/// The objects at an instant, extrapolated; where no scene has come, as the config has them.
PointScene scene_at(const ContactModel& model, const SceneFrame* scene, const ServoFrame& servo,
                    int64_t t_ns);

/// The objects' velocities in W at the hand's instant; zero where no scene has come.
PerObject<Twist> twists_at(const ContactModel& model, const SceneFrame* scene,
                           const ServoFrame& servo);

/// The contact of a sphere of the scene's radius with this facet, where that supports it; edges
/// smoother than the crease are shaded.
Contact contact_at(const PointScene& scene, const ProxyPlane& facet, const ProxySupport& at,
                   double crease_cosine);

}  // namespace haptic
