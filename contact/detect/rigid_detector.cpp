// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/rigid_detector.h"

#include "contact/detect/body/contact_reach.h"
#include "contact/query/triangle/shading_normal.h"
#include "proto/math/assert.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr int kPatience = 500;  // steps, half a second at 1 kHz, that it waits for a free path

Pose led_to(const ContactModel& model, const ServoFrame& servo) {
  const bool has_mass =
      is_renderer(servo.renderer) && row_of(static_cast<Renderer>(servo.renderer)).has_mass;
  const bool by_servo = model.has_friction || has_mass;
  return by_servo ? servo.X_WP : servo.X_WT;
}

PlanePatch tool_reach(const NearContact& at, const TriangleMesh& object, const TriangleMesh& tool,
                      const Pose& X_TO) {
  const FeaturePair features = features_of(at.feature);
  return contact_reach(
      {object, at.triangles.a, features.a, at.point_a, at.normal_A},
      {tool, at.triangles.b, features.b, X_TO * at.point_b, rotate(X_TO.q, -at.normal_A)},
      inverse(X_TO));
}

Contact contact_of(const GodObjectContact& contact, const ContactModel& model, const Pose& X_TO) {
  HAPTIC_ASSERT(contact.object < model.shapes.size());
  const NearContact& at = contact.at;
  const double crease_cosine = model.crease_cosine[contact.object];
  Contact c{};
  c.tool_point_T = X_TO * at.point_b;
  // the margin counts as part of the object
  c.object_point_O = at.point_a + model.rigid.margin * at.normal_A;
  c.normal_O = at.normal_A;
  c.shading_normal_O = crease_cosine < 1 ? shading_normal(model.shapes[contact.object].mesh,
                                                          at.triangles.a, at.point_a, crease_cosine)
                                         : at.normal_A;
  const PlanePatch reach = tool_reach(at, model.shapes[contact.object].mesh, model.tool.mesh, X_TO);
  c.extent = reach.extent;
  c.curvature = reach.curvature;
  c.object = contact.object;
  c.feature = at.feature;
  return c;
}

/// A plane that holds the tool for one tick where the moves were used up, normal to the rest of the
/// way: this is sticky, but prevents tunnelling.
Contact hold_of(const ContactSet& set) {
  HAPTIC_ASSERT(set.X_WG.p != set.X_WT.p);
  const Contact* nearest = set.contacts.empty() ? nullptr : set.contacts.data();
  Contact c{};
  c.object = nearest != nullptr ? nearest->object : 0;
  const Pose X_OW = inverse(set.objects[c.object].X_WO);
  c.object_point_O = X_OW * set.X_WG.p;
  c.normal_O = c.shading_normal_O = rotate(X_OW.q, normalized(set.X_WG.p - set.X_WT.p));
  return c;
}

}  // namespace

RigidDetector::RigidDetector(const ContactModel& model) {
  if (model.has_tool()) god_object_.emplace(model.shapes, model.tool, model.body, model.rigid);
}

void RigidDetector::place(const ServoFrame& servo, std::span<const Pose> X_WO, ContactSet& set) {
  if ((servo.flags & kServoClosed) != 0) {
    if (!god_object_->place(X_WO, servo.X_WT)) set.flags |= kContactNoFreePose;
    return;
  }
  // a restarted contact continues at the servo's verified pose
  const bool is_known = (servo.flags & kServoNoContactSet) == 0;
  if (is_known && god_object_->place(X_WO, servo.X_WG)) return;
  const bool is_found = god_object_->place_near(X_WO, servo.X_WT);
  if (!is_found) {
    set.flags |= kContactNoFreePose;
  } else if (god_object_->X_WG() != servo.X_WT) {
    set.flags |= kContactReseeded;
  }
}

/// No force until a path is found; after kPatience steps the tool restarts at the hand, without a
/// force, once it is free there.
void RigidDetector::wait(const ServoFrame& servo, std::span<const Pose> X_WO, ContactSet& set) {
  const bool is_anew = n_lost_ > kPatience && god_object_->place(X_WO, servo.X_WT);
  set.flags |= is_anew ? kContactReseeded : kContactNoFreePose;
}

void RigidDetector::report(const ContactModel& model, const ServoFrame& servo, ContactSet& set) {
  const Pose X_TW = inverse(set.X_WG);
  for (const GodObjectContact& contact : god_object_->contacts(servo.X_WP)) {
    const Pose X_TO = X_TW * set.objects[contact.object].X_WO;
    HAPTIC_ASSERT(!set.contacts.full());
    set.contacts.push_back(contact_of(contact, model, X_TO));
  }
}

void RigidDetector::detect(const ContactModel& model, const ContactQuestion& question,
                           ContactSet& set) {
  if (question.changed && god_object_) god_object_->lose();
  if (!question.usable) return;
  if (question.changed) set.flags |= kContactReseeded;
  set.X_WG = question.servo.X_WP;
  if (!god_object_) {
    set.flags |= kContactNoDetector | kContactNoFreePose;
    return;
  }
  answer(model, question, set);
}

void RigidDetector::answer(const ContactModel& model, const ContactQuestion& question,
                           ContactSet& set) {
  HAPTIC_ASSERT(set.contacts.empty());
  const ServoFrame& servo = question.servo;
  const std::span X_WO(question.now.X_WO.data(), model.shapes.size());
  set.tool = model.body;
  set.X_WG = set.X_WT = led_to(model, servo);
  if ((servo.flags & kServoClosed) != 0) god_object_->lose();
  // the servo projects in the metric of its springs; another one here gives other planes
  if (servo.translational_stiffness > 0 && servo.rotational_stiffness > 0) {
    god_object_->set_springs(servo.translational_stiffness, servo.rotational_stiffness);
  }
  if (!god_object_->is_placed()) place(servo, X_WO, set);
  if (!god_object_->is_placed()) return;
  const GodObjectMove move = god_object_->move(X_WO, set.X_WT, question.reach);
  n_lost_ = move.is_lost ? n_lost_ + 1 : 0;
  if (move.is_lost) {
    wait(servo, X_WO, set);
    return;
  }
  set.X_WG = god_object_->X_WG();
  if (move.is_behind) {
    // the planes move on from where the tool is free of the objects
    for (size_t i = 0; i < X_WO.size(); ++i) set.objects[i].X_WO = god_object_->X_WO(i);
    set.flags |= kContactIterationLimit;
  }
  report(model, servo, set);
  if (!move.is_settled) {
    set.flags |= kContactIterationLimit;
    if (set.contacts.full()) set.contacts.resize(kMaxContacts - 1);
    HAPTIC_ASSERT(!set.contacts.full());
    if (set.X_WG.p != set.X_WT.p) set.contacts.push_back(hold_of(set));
  }
  set.n_active = std::min(move.n_active, static_cast<uint32_t>(set.contacts.size()));
}

}  // namespace haptic
