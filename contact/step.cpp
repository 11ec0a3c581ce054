// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/step.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/wire/look_ahead.h"
#include "proto/wire/renderer.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

constexpr double kPeriodSmoothing = 0.1;  // weight of the newest interval
constexpr double kMaxPeriod = 0.1;        // longer intervals are pauses, not a rate [s]

double look_ahead(const ContactModel& model, ContactState& state, const ServoFrame& servo,
                  const SceneFrame* scene) {
  if (state.last_answered_ns != 0) {
    const double interval = static_cast<double>(servo.t_ns - state.last_answered_ns) * 1e-9;
    state.period += kPeriodSmoothing * (std::clamp(interval, 0.0, kMaxPeriod) - state.period);
  }
  state.last_answered_ns = servo.t_ns;
  double speed = norm(servo.V_WT.v);
  // the rim of a body may be faster than the hand, and its proxy faster than both
  if (is_of_body(state.renderer)) {
    const double rim = norm(model.body.centre_T) + model.body.radius;
    speed =
        std::max(speed + rim * norm(servo.V_WT.w), norm(servo.V_WP.v) + rim * norm(servo.V_WP.w));
  }
  double scene_speed = 0;
  if (scene != nullptr) {
    for (uint32_t i = 0; i < scene->objects.size(); ++i) {
      const Vec3 v_W = surface_velocity(*scene, i, scene->objects[i].X_WO, servo.X_WT.p, servo.t_ns,
                                        push_of(servo, model.hand));
      scene_speed = std::max(scene_speed, norm(v_W));
    }
  }
  speed += scene_speed;
  return look_ahead_reach(speed, state.period, model.servo_period, is_of_body(state.renderer),
                          (servo.device.flags & kDeviceAdmittance) != 0);
}

/// Frames of the servo between the last one that was answered and this one; the ticks that the
/// servo skipped itself are none. A servo that has begun anew is not compared with the one before.
uint64_t unanswered_between(const AnsweredTick& last, const ServoFrame& servo) {
  if (last.tick == 0 || servo.tick <= last.tick || servo.skipped < last.skipped) return 0;
  const uint64_t between = servo.tick - last.tick - 1, skipped = servo.skipped - last.skipped;
  return between > skipped ? between - skipped : 0;
}

/// The header of an answer: the fields that do not depend on the detector.
ContactSet begin_set(const ServoFrame& servo, const SceneFrame* scene) {
  ContactSet set{};
  set.answers_tick = servo.tick;
  set.answers_t_ns = servo.t_ns;
  set.X_WT = servo.X_WT;
  if (is_finite(servo.X_WT)) set.X_WG = servo.X_WT;
  if (scene != nullptr) set.scene_seq = scene->seq;
  return set;
}

bool is_usable(const ServoFrame& servo, const PointScene& now) {
  bool usable = is_finite(servo.X_WT) && is_finite(servo.V_WT) && is_finite(servo.held_back_W) &&
                is_finite(servo.X_WP) && is_finite(servo.V_WP) &&
                std::isfinite(servo.translational_stiffness) &&
                std::isfinite(servo.rotational_stiffness);
  for (size_t i = 0; i < now.shapes.size(); ++i) usable &= is_finite(now.X_WO[i]);
  return usable;
}

}  // namespace

ContactState::ContactState(const ContactModel& model)
    : renderer(model.renderer), given(begin_given_touch(model.given)) {
  // a question that is not usable makes what the detector keeps, before the first real one
  const ServoFrame servo{};
  const PointScene now = scene_at(model, nullptr, servo, 0);
  ContactQuestion question{servo, nullptr, renderer, now};
  question.usable = false;
  ContactSet set{};
  detect(model, detector, question, set);
}

ContactSet contact_step(const ContactModel& model, ContactState& state, const ServoFrame& hand,
                        const SceneFrame* scene) {
  HAPTIC_ASSERT(model.servo_period > 0 && state.period >= 0);
  const bool seizes = follow_button(state.grasp, model.grasp_button, hand);
  PointScene now = scene_at(model, scene, hand, hand.t_ns);
  // a frame is long: it is copied only where something is held
  ServoFrame drawn;
  if (state.grasp.holds()) drawn = drawn_frame(state.grasp, model.hand, hand, scene, now);
  const ServoFrame& servo = state.grasp.holds() ? drawn : hand;
  ContactSet set = begin_set(servo, scene);
  state.skipped += unanswered_between(state.last, hand);
  state.last = {hand.tick, hand.skipped};
  set.skipped = state.skipped;
  set.behind_since_ns = state.behind.seen(state.skipped, hand.t_ns);
  set.seq = state.seq++;
  const auto renderer =
      is_renderer(servo.renderer) ? static_cast<Renderer>(servo.renderer) : state.renderer;
  ContactQuestion question{servo, scene, renderer, now};
  question.changed = renderer != state.renderer && state.seq > 1;
  state.renderer = renderer;
  set.renderer = static_cast<uint32_t>(renderer);
  for (const Pose& X_WO : now.X_WO) set.objects.push_back({X_WO, 0});
  now.radius = row_of(renderer).moves == Moves::kSphere ? model.radius : 0;
  question.usable = is_usable(servo, now);
  question.reach = look_ahead(model, state, servo, scene);
  if (!question.usable) set.flags |= kContactNoFreePose;

  detect(model, state.detector, question, set);
  HAPTIC_ASSERT(set.n_active <= set.contacts.size());
  if ((set.flags & kContactNoFreePose) != 0) {
    set.contacts.clear();
    set.n_active = 0;
  }
  if (seizes && !state.grasp.holds()) seize(state.grasp, model, servo, set);
  if (state.grasp.holds()) report_grasp(state.grasp, model, set);
  add_given(model.given, state.given, hand, {state.grasp.object, question.reach + now.radius}, set);
  if ((set.flags & (kContactReseeded | kContactNoFreePose)) != 0) ++state.reseeds;
  set.reseeds = state.reseeds;
  return set;
}

}  // namespace haptic
