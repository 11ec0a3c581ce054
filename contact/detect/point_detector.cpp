// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point_detector.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kLeastReach = 25e-6;  // of the look-ahead where a set has no room for all [m]

/// A pose the servo still shows as verified and feels, else the tool itself.
uint32_t seed(const PointScene& scene, const ServoFrame& servo, PointProxy& proxy) {
  const bool known =
      (servo.flags & (kServoNoContactSet | kServoClosed)) == 0 && is_finite(servo.X_WG);
  if (known && seed_proxy(scene, servo.X_WG.p, proxy) == 0) return 0;
  return seed_proxy(scene, servo.X_WT.p, proxy);
}

/// After a change of renderer: keeps the place of the proxy, which may now need more room.
uint32_t seed_again(const PointScene& scene, const ServoFrame& servo, PointProxy& proxy) {
  const uint32_t flags = seed_proxy(scene, proxy.seeded ? proxy.g_W : servo.X_WT.p, proxy);
  return flags | kContactReseeded;
}

/// Shading is for the virtual proxy.
double crease_cosine(const ContactModel& model, const ContactSet& set, uint32_t object) {
  const bool shades = row_of(static_cast<Renderer>(set.renderer)).moves == Moves::kSphere;
  return shades ? model.crease_cosine[object] : 1;
}

/// Across the way from where the slide was cut short to the tool: the proxy stays where it is for
/// this tick, which is sticky, but never a hole.
void add_hold(const PointScene& scene, const PointProxy& proxy, const ProxyMove& move,
              const Vec3& p_W, ContactSet& set) {
  HAPTIC_ASSERT(move.n_active > 0 && !set.contacts.full());
  const ProxyPlane& facet = move.active[0];
  const Pose X_OW = inverse(scene.X_WO[facet.object]);
  const Vec3 across_O = rotate(X_OW.q, normalized(proxy.g_W - p_W));
  // the proxy's own place, less the stand-off of a sphere that the servo adds
  const Vec3 point_O = X_OW * proxy.g_W - scene.radius * across_O;
  const Feature face{FeatureKind::kFace, facet.triangle};
  set.contacts.push_back(contact_at(scene, facet, {face, point_O, across_O}, 1));
  set.n_active = static_cast<uint32_t>(set.contacts.size());
}

void add_active(const ContactModel& model, const PointScene& scene, const PointProxy& proxy,
                const ProxyMove& move, ContactSet& set) {
  for (uint32_t i = 0; i < move.n_active; ++i) {
    HAPTIC_ASSERT(i < move.active.size() && !set.contacts.full());
    const ProxyPlane& plane = move.active[i];
    // on the facet itself: the force is taken from the un-offset proxy
    set.contacts.push_back(contact_at(scene, plane, support_of(scene, plane, proxy.g_W),
                                      crease_cosine(model, set, plane.object)));
  }
  set.n_active = static_cast<uint32_t>(set.contacts.size());
}

bool is_reported(const ContactSet& set, uint32_t object, const Feature& feature) {
  return std::ranges::any_of(set.contacts, [&](const Contact& c) {
    return c.object == object && c.feature == feature.id();
  });
}

void add_approaching(const ContactModel& model, const PointScene& scene, const PointProxy& proxy,
                     double reach, PointDetector& state, ContactSet& set) {
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    const Vec3 g_O = inverse(scene.X_WO[i]) * proxy.g_W;
    NearResult near =
        near_features(scene.shapes[i], g_O, scene.radius + reach, state.scratch, state.features);
    if (near.truncated || near.left_out > 0) set.flags |= kContactTruncated;
    // a large sphere over small facets: what is nearest counts more than what is far
    for (double less = reach; near.truncated && less > kLeastReach;) {
      less /= 2;
      near =
          near_features(scene.shapes[i], g_O, scene.radius + less, state.scratch, state.features);
    }
    for (size_t k = 0; k < near.count; ++k) {
      const auto& [closest, normal_O] = state.features[k];
      if (is_reported(set, i, closest.feature)) continue;
      if (set.contacts.full()) {
        set.flags |= kContactTruncated;
        return;
      }
      set.contacts.push_back(contact_at(scene, {i, closest.triangle},
                                        {closest.feature, closest.point_O, normal_O},
                                        crease_cosine(model, set, i)));
    }
  }
}

/// Adds the facets that will support a proxy led on to p_W, where the tool will be when the answer
/// is used, and the facets that it may reach.
void add_contacts(const ContactModel& model, const PointScene& then, const Vec3& p_W, double reach,
                  PointDetector& state, ContactSet& set) {
  // it goes ahead and is put back; what its queries found serves the next step as well
  PointProxy& proxy = state.proxy;
  const ProxyPlace verified = proxy;
  const ProxyMove move = move_proxy(then, p_W, proxy);
  set.flags |= move.flags & (kContactIterationLimit | kContactTruncated);
  if ((move.flags & kContactIterationLimit) != 0 && move.n_active > 0) {
    add_hold(then, proxy, move, p_W, set);
  } else {
    add_active(model, then, proxy, move, set);
  }
  add_approaching(model, then, proxy, reach, state, set);
  static_cast<ProxyPlace&>(proxy) = verified;
}

/// Moves the proxy and reports the contacts of the place where it will be when they are used.
void lead(const ContactModel& model, PointDetector& state, const ContactQuestion& question,
          ContactSet& set) {
  const ServoFrame& servo = question.servo;
  HAPTIC_ASSERT(model.prediction >= 0 && state.proxy.seeded);
  const Vec3 goal_W = servo.X_WT.p + servo.held_back_W;
  const ProxyMove move = move_proxy(question.now, goal_W, state.proxy);
  set.flags |= move.flags;
  const auto ahead_ns = static_cast<int64_t>(model.prediction * 1e9);
  PointScene then = scene_at(model, question.scene, servo, servo.t_ns + ahead_ns);
  then.radius = question.now.radius;
  add_contacts(model, then, goal_W + model.prediction * servo.V_WT.v, question.reach, state, set);
}

}  // namespace

void PointDetector::detect(const ContactModel& model, const ContactQuestion& question,
                           ContactSet& set) {
  const ServoFrame& servo = question.servo;
  // nothing is felt: the hand may pass through objects, and begins where it then is
  if (question.usable && (servo.flags & kServoClosed) != 0) proxy.seeded = false;
  if (question.usable && question.changed) {
    set.flags |= seed_again(question.now, servo, proxy);
  } else if (question.usable && !proxy.seeded) {
    set.flags |= seed(question.now, servo, proxy);
  }
  if (question.usable && proxy.seeded) lead(model, *this, question, set);
  set.X_WG = {proxy.g_W, servo.X_WT.q};
  // crushed between objects, or nowhere to start: seed anew next time
  if ((set.flags & kContactNoFreePose) != 0) proxy.seeded = false;
}

}  // namespace haptic
