// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/grasp.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/wire/guide.h"
#include "proto/wire/look_ahead.h"
#include "proto/wire/mapping.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

double strength_of(const Grasp& grasp, const ServoFrame& servo) {
  const double since = static_cast<double>(servo.t_ns - grasp.since_ns) * 1e-9;
  return std::clamp(since / kGraspTime, 0.0, 1.0);
}

const RendererRow& renderer_of(const ContactSet& set) {
  return row_of(static_cast<Renderer>(set.renderer));
}

/// Gap between the proxy and a contact's plane [m].
double gap_of(const ContactModel& model, const ContactSet& set, const Contact& c) {
  const Pose& X_WO = set.objects[c.object].X_WO;
  const bool is_body = renderer_of(set).moves >= Moves::kSoftBody;
  const Vec3 tool_W = is_body ? place_of(set) * c.tool_point_T : place_of(set).p;
  const double radius = renderer_of(set).moves == Moves::kSphere ? model.radius : 0;
  return dot(rotate(X_WO.q, c.normal_O), tool_W - X_WO * c.object_point_O) - radius;
}

GuideRow guide_row(const Grasp& grasp, const Vec3& tool_point_T, const Vec3& normal_O,
                   uint32_t index) {
  GuideRow row{};
  row.tool_point_T = tool_point_T;
  row.object_point_O = grasp.X_OT * tool_point_T;
  row.normal_O = normal_O;
  row.object = grasp.object;
  row.row = index;
  return row;
}

constexpr std::array<Vec3, 3> kAxes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

void add_guides(const Grasp& grasp, const ContactModel& model, ContactSet& set) {
  const bool is_body = renderer_of(set).moves >= Moves::kSoftBody;
  const uint32_t n_guides = is_body ? 6 : 3;
  const ToolBody& body = model.body;
  for (uint32_t i = 0; i < n_guides; ++i) {
    const size_t k = i % 3;
    Vec3 point_T = is_body ? body.centre_T : Vec3{};
    if (i >= 3) point_T += body.radius * kAxes[(k + 2) % 3];
    const Vec3 normal_O = is_body ? rotate(grasp.X_OT.q, kAxes[k]) : kAxes[k];
    set.guides.push_back(guide_row(grasp, point_T, normal_O, i));
  }
}

}  // namespace

bool follow_button(Grasp& grasp, int32_t button, const ServoFrame& servo) {
  const bool is_down = is_pressed(servo.device, button);
  const uint32_t shut = kServoClosed | kServoClutched | kServoNoContactSet;
  const bool is_felt = (servo.flags & shut) == 0 && (servo.device.flags & kDeviceAdmittance) == 0;
  const bool has_gone_down = is_down && !grasp.was_pressed;
  grasp.was_pressed = is_down;
  if (!is_down || !is_felt) grasp.object = kMaxObjects;
  return has_gone_down && is_felt;
}

ServoFrame drawn_frame(const Grasp& grasp, uint32_t hand, const ServoFrame& servo,
                       const SceneFrame* scene, const PointScene& now) {
  HAPTIC_ASSERT(grasp.holds());
  ServoFrame drawn = servo;
  const double strength = strength_of(grasp, servo);
  const Pose& X_WO = now.X_WO[grasp.object];
  Pose X_WP = X_WO * grasp.X_OT;
  Twist V_WP;
  if (scene != nullptr && grasp.object < scene->objects.size()) {
    const Twist V_WO = object_twist_at(*scene, grasp.object, servo.t_ns, push_of(servo, hand));
    V_WP = twist_with(V_WO, X_WP.p - X_WO.p);
  }
  const bool is_body =
      is_renderer(servo.renderer) && is_of_body(static_cast<Renderer>(servo.renderer));
  if (!is_body) X_WP.q = servo.X_WT.q, V_WP.w = servo.V_WT.w;
  drawn.X_WT = drawn_towards(servo.X_WT, X_WP, strength);
  drawn.V_WT = drawn_towards(servo.V_WT, V_WP, strength);
  return drawn;
}

void seize(Grasp& grasp, const ContactModel& model, const ServoFrame& servo,
           const ContactSet& set) {
  HAPTIC_ASSERT(!grasp.holds());
  double nearest = kMinReach;
  for (const Contact& c : set.contacts) {
    const double gap = gap_of(model, set, c);
    // a hand holds no tool of another
    if (c.object >= model.shapes.size() - model.n_tools || !(gap <= nearest)) continue;
    nearest = gap;
    grasp.object = c.object;
  }
  if (!grasp.holds()) return;
  grasp.X_OT = inverse(set.objects[grasp.object].X_WO) * place_of(set);
  grasp.since_ns = servo.t_ns;
}

void report_grasp(Grasp& grasp, const ContactModel& model, ContactSet& set) {
  HAPTIC_ASSERT(grasp.holds() && set.guides.empty());
  // crushed, or without a place: what follows begins without a force
  if ((set.flags & kContactNoFreePose) != 0) {
    grasp.object = kMaxObjects;
    return;
  }
  add_guides(grasp, model, set);
}

}  // namespace haptic
